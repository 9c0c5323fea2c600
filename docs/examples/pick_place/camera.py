"""The camera, simulated: it stands on the robot and sees what is in front of it."""

import math
from typing import Any

from angles import yaw_of
from rosbase import BaseNode
from rosbase.messages import Pose, PoseStamped, String

PERIOD_S = 0.02
HALF_VIEW_RAD = 0.6
THINGS_M = {"cup": (0.6, 0.6), "tray": (0.2, 0.8)}


class Camera(BaseNode):
    """Publishes `image`: a line for each thing in view, with how far ahead and left it is, in m.

    A real one would publish sensor_msgs/Image here, and the tracker would look at pixels.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.img: String | None = None
        self.pose: Pose | None = None
        self.image = self.create_publisher(String, "image")
        self.create_subscription(PoseStamped, "pose", self.on_pose)
        self.create_timer(PERIOD_S, self.take_picture)

    def on_pose(self, message: PoseStamped) -> None:
        """Called with where the robot is, and the camera with it."""
        self.pose = message.pose

    def take_picture(self) -> None:
        """Called by the timer."""
        if self.pose is None:
            return
        lines = []
        for name, (x, y) in THINGS_M.items():
            ahead, left = seen_from(self.pose, x, y)
            if abs(math.atan2(left, ahead)) < HALF_VIEW_RAD:
                lines.append(f"{name} {ahead:.3f} {left:.3f}")
        self.img = String("\n".join(lines))
        self.image.publish(self.img)


def seen_from(pose: Pose, x: float, y: float) -> tuple[float, float]:
    """How far ahead and how far left of the robot a place is."""
    dx, dy, yaw = x - pose.position.x, y - pose.position.y, yaw_of(pose.orientation)
    return (
        dx * math.cos(yaw) + dy * math.sin(yaw),
        dy * math.cos(yaw) - dx * math.sin(yaw),
    )
