"""The manager of the robot: what must be there before it moves, and what is closed at its end."""

from typing import Any

from handlers import QuadrupedHandlers
from rosbase import BaseManager


class QuadrupedManager(BaseManager):
    """Waits for the legs and the joystick, then walks."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        kwargs["handlers_class"] = QuadrupedHandlers
        super().__init__(*args, **kwargs)
        self.add_handshake_rule("Legs: attitude", lambda: self.nodes["bridge"].imu is not None)
        self.add_handshake_rule("Legs: pose", lambda: self.nodes["bridge"].pose is not None)
        self.add_handshake_rule("Joystick", lambda: self.nodes["bridge"].joy is not None)

    def release_resources(self) -> None:
        """Called when the application ends, however it ends."""
        for node in self.nodes.values():
            node.release_resources()
