"""The ROS clock for stamps, and this machine's for waiting."""

import time
from typing import Any

from builtin_interfaces.msg import Time as RosTime

from rosbase import SystemClock, messages

__all__ = ["RosClock", "Time"]


class Time(messages.Time):
    """A time that ROS messages take as well as those of rosbase."""

    __slots__ = ()

    def to_msg(self) -> Any:
        """Return the time as a field of ROS messages takes it."""
        return RosTime(sec=self.sec, nanosec=self.nanosec)


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

    def now(self) -> messages.Time:
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(self.now_ns())

    def now_ns(self) -> int:
        """Return the date in nanoseconds since the Unix epoch, or since the simulation's."""
        # Asking rclpy for the system's time costs ten times as much as asking the system.
        return self.clock.now().nanoseconds if self.is_simulated else time.time_ns()
