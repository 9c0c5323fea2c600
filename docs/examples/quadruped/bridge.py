"""The way to the legs and to the operator, and back."""

from typing import Any

from angles import roll_of
from rosbase import BaseNode
from rosbase.messages import Imu, Joy, PoseStamped, String, Twist, Vector3

PERIOD_S = 0.02
STOP_BUTTON = 1
FALLEN_RAD = 0.8
LEVEL_RAD = 0.1
STANDING_M = 0.28


class Bridge(BaseNode):
    """Keeps what legs and joystick say, and repeats the command and the state.

    They are repeated, so that one that is lost does no harm, and who comes late hears them too.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.joy: Joy | None = None
        self.is_stopped = False
        self.imu = self.latest(Imu, "imu")
        self.pose = self.latest(PoseStamped, "pose")
        self.gait = "lie"
        self.velocity = Twist()
        self.cmd_vel = self.create_publisher(Twist, "cmd_vel")
        self.gaits = self.create_publisher(String, "gait")
        self.states = self.create_publisher(String, "state")
        self.create_subscription(Joy, "joy", self.on_joy)
        self.create_timer(PERIOD_S, self.send)

    def on_joy(self, message: Joy) -> None:
        """Called with every message of a joystick: the stop counts, whatever follows it."""
        self.joy = message
        self.is_stopped = self.is_stopped or message.buttons[STOP_BUTTON] == 1

    def stick(self) -> Twist:
        """What the operator's stick asks for."""
        if self.joy is None:
            return Twist()
        left, forward = self.joy.axes
        return Twist(Vector3(x=0.8 * forward), Vector3(z=1.5 * left))

    def is_pressed(self, button: int) -> bool:
        """Whether the operator holds that button."""
        return self.joy is not None and self.joy.buttons[button] == 1

    def has_fallen(self) -> bool:
        """Whether the body lies on its side."""
        imu = self.imu.value
        return imu is not None and abs(roll_of(imu.orientation)) > FALLEN_RAD

    def is_standing(self) -> bool:
        """Whether the body is level, and as high as its legs are long."""
        imu, pose = self.imu.value, self.pose.value
        if imu is None or pose is None:
            return False
        is_level = abs(roll_of(imu.orientation)) < LEVEL_RAD
        return is_level and pose.pose.position.z > STANDING_M

    def command(self, gait: str, velocity: Twist | None = None) -> None:
        """Has the legs do that until told otherwise."""
        self.gait = gait
        self.velocity = velocity or Twist()

    def send(self) -> None:
        """Called by the timer."""
        self.gaits.publish(String(self.gait))
        self.cmd_vel.publish(self.velocity)
        state = self.manager.state if self.manager is not None else None
        self.states.publish(String(state or ""))

    def release_resources(self) -> None:
        """Called by the manager at the end: the legs must not walk on."""
        self.command("lie")
        self.send()
