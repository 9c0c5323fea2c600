"""The robot, simulated: a base that drives and turns, and a gripper with two fingers."""

import math
from typing import Any

from angles import quaternion_of
from rosbase import BaseNode
from rosbase.messages import Bool, Header, JointState, Point, Pose, PoseStamped, Twist

PERIOD_S = 0.02
OPEN_M = 0.08
CUP_M = 0.03
FINGER_STEP_M = 0.01


class SimulatedRobot(BaseNode):
    """Obeys `cmd_vel` and `gripper`, publishes `pose` and `joint_states`.

    Its first grasp slips, so that the retry can be seen. With a real robot, leave this node out.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.velocity = Twist()
        self.is_closing = False
        self.grasps = 0
        self.x, self.y, self.yaw = 0.0, 0.0, 0.0
        self.fingers_m = OPEN_M
        self.pose = self.create_publisher(PoseStamped, "pose")
        self.joints = self.create_publisher(JointState, "joint_states")
        self.create_subscription(Twist, "cmd_vel", self.on_velocity)
        self.create_subscription(Bool, "gripper", self.on_gripper)
        self.create_timer(PERIOD_S, self.move)

    def on_velocity(self, message: Twist) -> None:
        """Called with the velocity to drive at."""
        self.velocity = message

    def on_gripper(self, message: Bool) -> None:
        """Called with whether the gripper shall be closed."""
        if message.data and not self.is_closing:
            self.grasps += 1
        self.is_closing = message.data

    def move(self) -> None:
        """Called by the timer: one period of motion."""
        self.yaw += self.velocity.angular.z * PERIOD_S
        self.x += self.velocity.linear.x * math.cos(self.yaw) * PERIOD_S
        self.y += self.velocity.linear.x * math.sin(self.yaw) * PERIOD_S
        if self.is_closing:
            closed_m = 0.0 if self.grasps == 1 else CUP_M
            self.fingers_m = max(closed_m, self.fingers_m - FINGER_STEP_M)
        else:
            self.fingers_m = min(OPEN_M, self.fingers_m + FINGER_STEP_M)
        self.report()

    def report(self) -> None:
        """Publishes where the base and the fingers are."""
        stamp = self.get_clock().now().to_msg()
        pose = Pose(Point(self.x, self.y), quaternion_of(self.yaw))
        self.pose.publish(PoseStamped(Header(stamp, "world"), pose))
        self.joints.publish(
            JointState(Header(stamp), name=("fingers",), position=(self.fingers_m,))
        )
