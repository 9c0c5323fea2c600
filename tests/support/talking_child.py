"""A node for a process of its own, which imports this module."""

from typing import Any

from rosbase import BaseNode
from rosbase.messages import String

__all__ = ["Talker"]


class Talker(BaseNode):
    """Talks to its manager, in a process of its own."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        publisher = self.create_publisher(String, "talk")
        numbers = iter(range(1000))
        self.create_timer(0.02, lambda: publisher.publish(String(f"number {next(numbers)}")))
