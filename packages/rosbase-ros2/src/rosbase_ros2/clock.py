"""The ROS clock for stamps, and this machine's for waiting."""

import time
from typing import Any

from rosbase import SystemClock
from rosbase.messages import Time

__all__ = ["RosClock"]


class RosClock(SystemClock):
    """Clock of the node: the system's, or `/clock` while `use_sim_time` is true.

    Deadlines stay on the monotonic clock of the machine.
    """

    def __init__(self, node: Any) -> None:
        """Take the clock of an rclpy node."""
        self.clock = node.get_clock()
        """Clock of rclpy."""

    @property
    def is_simulated(self) -> bool:
        """Whether the time comes from `/clock`."""
        return bool(self.clock.ros_time_is_active)

    def now(self) -> Time:
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(self.now_ns())

    def now_ns(self) -> int:
        """Return the date in nanoseconds since the Unix epoch, or since the simulation's."""
        # Asking rclpy for the system's time costs ten times as much as asking the system.
        return self.clock.now().nanoseconds if self.is_simulated else time.time_ns()
