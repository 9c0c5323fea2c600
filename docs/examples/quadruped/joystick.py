"""The operator with the joystick, played from a script."""

from typing import Any

from rosbase import BaseNode
from rosbase.messages import Joy, String

PERIOD_S = 0.02
WALK_PERIODS = 20
FORWARD = (0.0, 1.0)
CENTRED = (0.0, 0.0)
NONE, AUTONOMOUS, STOP = (0, 0), (1, 0), (0, 1)


class ScriptedJoystick(BaseNode):
    """Publishes `joy`, as the driver of a real joystick does.

    The operator watches the state. Whenever it is theirs to drive they walk on for a while; the
    first time they then press for the autonomous walk, the second time for the emergency stop.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.seen = ""
        self.turns = 0
        self.periods = 0
        self.joy = self.create_publisher(Joy, "joy")
        self.create_subscription(String, "state", self.on_state)
        self.create_timer(PERIOD_S, self.play)

    def on_state(self, message: String) -> None:
        """Called with the state of the robot."""
        if message.data == "human_teleop" and self.seen != "human_teleop":
            self.turns += 1
            self.periods = 0
        self.seen = message.data

    def play(self) -> None:
        """Called by the timer."""
        if self.seen != "human_teleop":
            self.joy.publish(Joy(axes=CENTRED, buttons=NONE))
            return
        self.periods += 1
        if self.periods <= WALK_PERIODS:
            self.joy.publish(Joy(axes=FORWARD, buttons=NONE))
        else:
            self.joy.publish(Joy(axes=CENTRED, buttons=AUTONOMOUS if self.turns == 1 else STOP))
