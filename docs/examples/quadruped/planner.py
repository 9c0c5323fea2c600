"""Plans the way to a goal."""

import math
from typing import Any

from angles import yaw_of
from rosbase import BaseAgent
from rosbase.messages import Pose, Twist, Vector3

EVERY_TICKS = 5
GOAL_M = (1.0, 0.4)


class Planner(BaseAgent):
    """Says how to walk to the goal. Planning is slow, so it plans only at every fifth tick."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.reset()

    def reset(self) -> None:
        """Called when a way begins: nothing is known until the first plan."""
        self.bearing_rad = math.inf
        self.distance_m = math.inf

    def plan(self, pose: Pose) -> None:
        """Called at every tick of a way."""
        if self.timestamp % EVERY_TICKS == 0:
            dx, dy = GOAL_M[0] - pose.position.x, GOAL_M[1] - pose.position.y
            error = math.atan2(dy, dx) - yaw_of(pose.orientation)
            self.bearing_rad = math.remainder(error, math.tau)
            self.distance_m = math.hypot(dx, dy)

    def turn(self) -> Twist:
        """Towards the goal, on the spot."""
        return Twist(angular=Vector3(z=self._turn_rad_s()))

    def walk(self) -> Twist:
        """Towards the goal."""
        if math.isinf(self.distance_m):
            return Twist()
        return Twist(Vector3(x=0.8), Vector3(z=self._turn_rad_s()))

    def _turn_rad_s(self) -> float:
        if math.isinf(self.bearing_rad):
            return 0.0
        return max(-1.5, min(1.5, 3.0 * self.bearing_rad))
