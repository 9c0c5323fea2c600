"""Finds in each picture the one thing that is looked for."""

import math
from typing import Any

from rosbase import BaseNode
from rosbase.messages import Header, Point, PointStamped, String


class Tracker(BaseNode):
    """Keeps where the target is in the robot's frame, and publishes it as `target`."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.wanted = ""
        self.position: Point | None = None
        self.target = self.create_publisher(PointStamped, "target")
        self.create_subscription(String, "image", self.on_image, 1)

    def look_for(self, name: str) -> None:
        """Forgets the target, and follows the thing of that name from the next picture on."""
        self.wanted = name
        self.position = None

    def on_image(self, message: String) -> None:
        """Called with each picture."""
        self.position = None
        for line in message.data.splitlines():
            name, ahead, left = line.split()
            if name == self.wanted:
                self.position = Point(float(ahead), float(left))
                stamp = self.get_clock().now().to_msg()
                self.target.publish(PointStamped(Header(stamp, "base"), self.position))

    @property
    def bearing_rad(self) -> float:
        """How far to the left of straight ahead the target is; 0 without one."""
        return math.atan2(self.position.y, self.position.x) if self.position is not None else 0.0

    @property
    def distance_m(self) -> float:
        """How far away the target is; 0 without one."""
        return math.hypot(self.position.x, self.position.y) if self.position is not None else 0.0
