"""Warn if a simulated clock is requested but nothing publishes it."""

from collections.abc import Callable
from typing import Any

from rclpy.clock import ClockChange, JumpThreshold

from rosbase import Executor, ExecutorTimer
from rosbase_ros2.clock import RosClock

__all__ = ["SimTimeWatch"]

_CHANGES = JumpThreshold(min_forward=None, min_backward=None, on_clock_change=True)
# Discovery takes some 3 s where it is slow.
_PATIENCE_NS = 5_000_000_000


class SimTimeWatch:
    """Warns once, some seconds after `use_sim_time` has been set, if nothing publishes `/clock`."""

    def __init__(
        self, node: Any, clock: RosClock, executor: Executor, warn: Callable[[str], object]
    ) -> None:
        """Start watching.

        Args:
            node: The rclpy node.
            clock: The clock of that node.
            executor: Times the check, on the clock of the machine.
            warn: Called with the line, on the main loop.
        """
        self._node = node
        self._clock = clock
        self._executor = executor
        self._warn = warn
        self._timer: ExecutorTimer | None = None
        self._jumps = clock.clock.create_jump_callback(_CHANGES, post_callback=self._on_change)
        if clock.is_simulated:
            self._begin()

    def close(self) -> None:
        """Stop watching."""
        self._jumps.unregister()

    def _on_change(self, jump: Any) -> None:
        # On the thread of whoever sets `use_sim_time`.
        if jump.clock_change == ClockChange.ROS_TIME_ACTIVATED:
            self._executor.call_soon(self._begin)

    def _begin(self) -> None:
        if self._timer is None:
            self._timer = self._executor.create_timer(_PATIENCE_NS, self._look)

    def _look(self) -> None:
        assert self._timer is not None
        self._timer.destroy()
        topic = self._node.resolve_topic_name("/clock")
        if self._clock.is_simulated and self._node.count_publishers(topic) == 0:
            self._warn(
                f"use_sim_time is true and nothing publishes {topic}: stamps are zero and timers"
                " stand still until something does"
            )
        else:
            # For the next time that it is set.
            self._timer = None
