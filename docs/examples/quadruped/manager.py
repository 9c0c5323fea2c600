"""The manager of the robot: what must be there before it moves, and what is closed at its end."""

from typing import Any

from bridge import Bridge
from handlers import QuadrupedHandlers
from rosbase import BaseManager


class QuadrupedManager(BaseManager):
    """Waits for the legs and the joystick, then walks."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        kwargs["handlers_class"] = QuadrupedHandlers
        super().__init__(*args, **kwargs)
        bridge = self.node(Bridge)
        self.add_handshake_rule("Legs: attitude", lambda: bridge.imu.value is not None)
        self.add_handshake_rule("Legs: pose", lambda: bridge.pose.value is not None)
        self.add_handshake_rule("Joystick", lambda: bridge.joy is not None)

    def release_resources(self) -> None:
        """Called when the application ends, however it ends."""
        for node in self.nodes.values():
            node.release_resources()
