"""The way to the robot and back."""

from typing import Any

from rosbase import BaseNode
from rosbase.messages import Bool, JointState, Twist, Vector3

PERIOD_S = 0.02


class Bridge(BaseNode):
    """Keeps what the robot says about itself, and repeats what it shall do.

    Commands are repeated, so that one that is lost does no harm.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.joints: JointState | None = None
        self.velocity = Twist()
        self.grip = Bool()
        self.cmd_vel = self.create_publisher(Twist, "cmd_vel")
        self.gripper = self.create_publisher(Bool, "gripper")
        self.create_subscription(JointState, "joint_states", self.on_joints)
        self.create_timer(PERIOD_S, self.send)

    def on_joints(self, message: JointState) -> None:
        """Called with where the fingers are."""
        self.joints = message

    @property
    def fingers_m(self) -> float:
        """How far the fingers are apart."""
        return self.joints.position[0] if self.joints is not None else 0.0

    def drive(self, forward_m_s: float, left_rad_s: float) -> None:
        """Has the robot drive and turn until told otherwise."""
        self.velocity = Twist(Vector3(x=forward_m_s), Vector3(z=left_rad_s))

    def stop(self) -> None:
        """Has the robot stand still."""
        self.velocity = Twist()

    def open_gripper(self) -> None:
        """Has the fingers open."""
        self.grip = Bool(data=False)

    def close_gripper(self) -> None:
        """Has the fingers close as far as they can."""
        self.grip = Bool(data=True)

    def send(self) -> None:
        """Called by the timer."""
        self.cmd_vel.publish(self.velocity)
        self.gripper.publish(self.grip)

    def release_resources(self) -> None:
        """Called by the manager at the end: the robot must not drive on."""
        self.stop()
        self.cmd_vel.publish(self.velocity)
