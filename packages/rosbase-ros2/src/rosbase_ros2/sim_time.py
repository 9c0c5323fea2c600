"""Warn if a simulated clock is requested but nothing publishes it."""

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock as RclpyClock
from rclpy.clock import ClockChange, ClockType, JumpThreshold

from rosbase import Executor
from rosbase_ros2.clock import RosClock
from rosbase_ros2.shared_node import OwnGroup

__all__ = ["SimTimeWatch"]

_CHANGES = JumpThreshold(min_forward=None, min_backward=None, on_clock_change=True)
# Discovery takes some 3 s where it is slow.
_PATIENCE_S = 5.0


class SimTimeWatch:
    """Warns once, some seconds after `use_sim_time` has been set, if nothing publishes `/clock`."""

    def __init__(
        self, node: Any, clock: RosClock, executor: Executor, warn: Callable[[str], object]
    ) -> None:
        """Start watching.

        Args:
            node: The rclpy node.
            clock: The clock of that node.
            executor: Begins the check, on the main loop.
            warn: Called with the line, on the thread of rclpy.
        """
        self._node = node
        self._clock = clock
        self._executor = executor
        self._warn = warn
        self._timer: Any = None
        self._jumps = clock.clock.create_jump_callback(_CHANGES, post_callback=self._on_change)
        if clock.is_simulated:
            self._begin()

    def close(self) -> None:
        """Stop watching."""
        self._jumps.unregister()

    def _on_change(self, jump: Any) -> None:
        # On the thread of whoever sets `use_sim_time`.
        if jump.clock_change == ClockChange.ROS_TIME_ACTIVATED:
            self._executor.call_aside(self._begin)

    def _begin(self) -> None:
        if self._timer is None:
            # Not the executor's: a recording has the timers of the program.
            clock = RclpyClock(clock_type=ClockType.STEADY_TIME)
            self._timer = self._node.create_timer(_PATIENCE_S, self._look, OwnGroup(), clock)

    def _look(self) -> None:
        assert self._timer is not None
        self._node.destroy_timer(self._timer)
        topic = self._node.resolve_topic_name("/clock")
        if self._clock.is_simulated and self._node.count_publishers(topic) == 0:
            self._warn(
                f"use_sim_time is true and nothing publishes {topic}: stamps are zero and timers"
                " stand still until something does"
            )
        else:
            # For the next time that it is set.
            self._timer = None
