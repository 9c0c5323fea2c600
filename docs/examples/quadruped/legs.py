"""The four legs, simulated: a body that walks, turns, stands up, lies down, and falls once."""

import math
from typing import Any

from angles import quaternion_of
from rosbase import BaseNode
from rosbase.messages import Header, Imu, Point, Pose, PoseStamped, String, Twist

PERIOD_S = 0.02
STANDING_M = 0.3
LYING_M = 0.1
RISE_M = 0.01
FALLEN_RAD = 1.2
ROLL_STEP_RAD = 0.06
STONE_AT_M = 0.65


class SimulatedLegs(BaseNode):
    """Obeys `cmd_vel` and `gait`, publishes `imu` and `pose`.

    It trips over a stone once, so that the recovery can be seen. With a real robot, leave this
    node out.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.velocity = Twist()
        self.gait = "lie"
        self.x, self.y, self.yaw = 0.0, 0.0, 0.0
        self.height_m, self.roll = LYING_M, 0.0
        self.walked_m = 0.0
        self.has_tripped = False
        self.imu = self.create_publisher(Imu, "imu")
        self.pose = self.create_publisher(PoseStamped, "pose")
        self.create_subscription(Twist, "cmd_vel", self.on_velocity)
        self.create_subscription(String, "gait", self.on_gait)
        self.create_timer(PERIOD_S, self.move)

    def on_velocity(self, message: Twist) -> None:
        """Called with the velocity to walk at."""
        self.velocity = message

    def on_gait(self, message: String) -> None:
        """Called with what the legs shall do: lie, stand or walk."""
        self.gait = message.data

    def move(self) -> None:
        """Called by the timer: one period of motion."""
        if self.gait == "walk":
            self.walk()
        elif self.gait == "stand":
            self.stand_up()
        else:
            self.height_m = max(LYING_M, self.height_m - RISE_M)
        self.report()

    def walk(self) -> None:
        """Goes on, unless it lies on its side."""
        if self.roll >= FALLEN_RAD:
            return
        step_m = self.velocity.linear.x * PERIOD_S
        self.yaw += self.velocity.angular.z * PERIOD_S
        self.x += step_m * math.cos(self.yaw)
        self.y += step_m * math.sin(self.yaw)
        self.walked_m += step_m
        if self.walked_m >= STONE_AT_M and not self.has_tripped:
            self.has_tripped = True
            self.roll = FALLEN_RAD

    def stand_up(self) -> None:
        """Rolls onto its feet, then rises."""
        self.roll = max(0.0, self.roll - ROLL_STEP_RAD)
        if self.roll == 0.0:
            self.height_m = min(STANDING_M, self.height_m + RISE_M)

    def report(self) -> None:
        """Publishes how the body leans, and where it is."""
        stamp = self.get_clock().now().to_msg()
        attitude = quaternion_of(self.roll, self.yaw)
        self.imu.publish(Imu(Header(stamp, "body"), orientation=attitude))
        pose = Pose(Point(self.x, self.y, self.height_m), attitude)
        self.pose.publish(PoseStamped(Header(stamp, "odom"), pose))
