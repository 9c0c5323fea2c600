"""The manager of the task: what must be there before it begins, and what is closed at its end."""

from collections.abc import Collection
from typing import Any

from bridge import Bridge
from camera import Camera
from handlers import PickPlaceHandlers
from rosbase import BaseManager


class PickPlaceRUN(BaseManager):
    """Waits for the streams that it is told to wait for, then runs the task."""

    def __init__(self, wait: Collection[str] = ("img", "robot"), *args: Any, **kwargs: Any) -> None:
        kwargs["handlers_class"] = PickPlaceHandlers
        super().__init__(*args, **kwargs)
        if "img" in wait:
            self.add_handshake_rule("Camera Stream", lambda: self.node(Camera).img is not None)
        if "robot" in wait:
            self.add_handshake_rule(
                "Robot Connection", lambda: self.node(Bridge).joints is not None
            )

    def release_resources(self) -> None:
        """Called when the application ends, however it ends."""
        for node in self.nodes.values():
            node.release_resources()
        for agent in self.agents.values():
            agent.close()
