"""Small components for tests of the roles."""

from typing import Any

from rosbase import (
    BaseAgent,
    BaseHandlers,
    BaseNode,
)
from rosbase.messages import Header


class Camera(BaseNode):
    def __init__(self, manager: Any = None, *args: Any, **kwargs: Any) -> None:
        super().__init__(manager, *args, **kwargs)
        self.img: Header | None = None
        self.create_subscription(Header, "image", self._keep, 1)
        self.publisher = self.create_publisher(Header, "image", 1)

    def _keep(self, message: Header) -> None:
        self.img = message


class Brain(BaseAgent):
    def __init__(self, manager: Any = None, *args: Any, gain: float = 1.0, **kwargs: Any) -> None:
        super().__init__(manager, *args, **kwargs)
        self.gain = gain

    def reset(self) -> None:
        self.gain = 0.0


class StopAfter(BaseHandlers):
    ticks = 5

    def handle(self) -> None:
        if self.timestamp + 1 >= self.ticks:
            self.manager.request_stop()
