"""Deliver published messages before a publisher is destroyed, because rclpy would drop them.

A subscriber acknowledges received messages on request, and Fast DDS asks every three seconds. So
ending a publisher does not wait for that: the publisher retires, and is destroyed later.
"""

from collections.abc import Iterable
from typing import Any

from rclpy.clock import Clock as RclpyClock
from rclpy.clock import ClockType
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle

from rosbase import Clock
from rosbase_ros2.deadline import Deadline
from rosbase_ros2.refusals import RCLError
from rosbase_ros2.shared_node import OwnGroup

__all__ = ["Retirement", "await_delivery"]

_LOOK_S = 0.1
_POLL_S = 0.001
_NOW = Duration()


class Retirement:
    """Publishers that send nothing more, kept until their last messages have arrived.

    Everything here happens on the thread of rclpy.
    """

    def __init__(self, node: Any) -> None:
        """Prepare for the publishers of an rclpy node. Remaining ones are destroyed with it."""
        self._node = node
        self._publishers: list[Any] = []
        self._timer: Any = None

    def take(self, publisher: Any) -> None:
        """Destroy a publisher of rclpy as soon as none of its messages is on its way."""
        self._publishers.append(publisher)
        self._look()

    def _look(self) -> None:
        for publisher in [p for p in self._publishers if _is_delivered(p)]:
            self._publishers.remove(publisher)
            self._node.destroy_publisher(publisher)
        if self._publishers and self._timer is None:
            # Not the node's clock, which may be a simulation's.
            clock = RclpyClock(clock_type=ClockType.STEADY_TIME)
            self._timer = self._node.create_timer(_LOOK_S, self._look, OwnGroup(), clock)
        elif self._timer is not None and not self._publishers:
            self._node.destroy_timer(self._timer)
            self._timer = None


def await_delivery(publishers: Iterable[Any], patience_s: float, clock: Clock) -> None:
    """Return when all messages of rclpy publishers have arrived, or the time is up."""
    deadline = Deadline(patience_s, clock)
    for publisher in publishers:
        # Given a time, rclpy waits with the interpreter locked, and all threads wait with it.
        while not _is_delivered(publisher) and deadline.left_s:
            clock.sleep(_POLL_S)


def _is_delivered(publisher: Any) -> bool:
    """Return whether every subscriber has acknowledged everything. An unreliable one need not."""
    try:
        return bool(publisher.wait_for_all_acked(_NOW))
    except (InvalidHandle, RCLError):
        # Somebody else has destroyed it meanwhile, or its context has ended.
        return True
