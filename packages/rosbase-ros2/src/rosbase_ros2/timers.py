"""Timers that follow `use_sim_time`: the machine's clock, or `/clock` while it is true.

On the machine's clock, the core's executor runs the timers directly. On `/clock` there are only
deadlines, checked whenever the clock moves. A timer of rclpy would fire at once when the clock is
found, and its calls would pile up while the main loop is busy.
"""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.clock import JumpThreshold
from rclpy.duration import Duration

from rosbase import ExecutorTimer
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind, TimerOp
from rosbase_ros2.clock import RosClock

__all__ = ["RosTimer", "Timers"]

_ANY_MOVE = JumpThreshold(
    min_forward=Duration(nanoseconds=1),
    min_backward=Duration(nanoseconds=-1),
    on_clock_change=True,
)


class RosTimer:
    """One timer. `Timers` changes it, under its lock."""

    __slots__ = ("_timers", "deadline_ns", "is_queued", "is_running", "life", "machine")

    def __init__(self, timers: "Timers", machine: ExecutorTimer) -> None:
        self._timers = timers
        self.machine = machine
        """Timer on the machine's clock; runs while that clock counts."""
        self.is_running = False
        """Whether it is running, by either clock."""
        self.deadline_ns: int | None = None
        """Deadline on `/clock`; None until the first time arrives."""
        self.is_queued = False
        """Whether a call waits for the main loop. There is never a second one."""
        self.life = 0
        """Number of the current life; calls queued in an earlier one do not count."""

    def cancel(self) -> None:
        """Stop the timer, until `reset`."""
        self._timers.stop(self)

    def reset(self) -> None:
        """Restart the timer: the next call is one period from now."""
        self._timers.start(self)

    def is_canceled(self) -> bool:
        """Return whether the timer is stopped."""
        return not self.is_running

    def move_to(self, now_ns: int) -> bool:
        """Take the time of `/clock`; return whether the timer was due by then."""
        period_ns = self.machine.period_ns
        if self.deadline_ns is None or self.deadline_ns - now_ns > period_ns:
            # The clock has just been found, or was set back.
            self.deadline_ns = now_ns + period_ns
        if self.deadline_ns > now_ns:
            return False
        self.deadline_ns += (1 + (now_ns - self.deadline_ns) // period_ns) * period_ns
        return True


class Timers:
    """The timers of one rclpy node."""

    def __init__(
        self,
        clock: RosClock,
        call_soon: Callable[[Callable[[], object]], None],
        conductor: Conductor | None = None,
    ) -> None:
        """Start watching the clock.

        Args:
            clock: The clock of the node.
            call_soon: Queues a function for the main loop.
            conductor: Records the program, if it is recorded.
        """
        self._clock = clock
        self._conductor = conductor
        self._call_soon = call_soon
        self._timers: list[RosTimer] = []
        # Whoever sets `use_sim_time`, and whoever hears `/clock`, moves timers on its thread.
        self._lock = threading.Lock()
        self._is_simulated = clock.is_simulated
        # What the clock says before it is heard is from long ago.
        self._is_heard = False
        self._watch = clock.clock.create_jump_callback(_ANY_MOVE, post_callback=self._on_jump)

    def now_ns(self) -> int:
        """Return the time that the timers follow."""
        return self._clock.now_ns() if self._clock.is_simulated else self._clock.monotonic_ns()

    def add(self, machine: ExecutorTimer) -> RosTimer:
        """Create a running timer, with the period and the callback of the executor's timer."""
        timer = RosTimer(self, machine)
        with self._lock:
            self._timers.append(timer)
            self._start(timer)
        return timer

    def remove(self, timer: RosTimer) -> None:
        """Stop a timer for good. Do nothing if it is stopped."""
        with self._lock:
            if timer in self._timers:
                self._timers.remove(timer)
                self._stop(timer)

    def start(self, timer: RosTimer) -> None:
        """Start a timer: it calls back one period from now, unless it has been removed."""
        with self._lock:
            if timer in self._timers:
                self._start(timer)

    def stop(self, timer: RosTimer) -> None:
        """Stop the calls of a timer."""
        with self._lock:
            self._stop(timer)

    def close(self) -> None:
        """Stop all timers for good, and stop watching the clock."""
        self._watch.unregister()
        for timer in list(self._timers):
            self.remove(timer)

    def _on_jump(self, jump: Any) -> None:
        with self._lock:
            if self._clock.is_simulated == self._is_simulated:
                self._move()
                return
            self._is_simulated = not self._is_simulated
            self._is_heard = False
            for timer in self._timers:
                if timer.is_running:
                    self._start(timer)

    def _move(self) -> None:
        self._is_heard = True
        now_ns = self._clock.now_ns()
        for timer in self._timers:
            if timer.is_running and timer.move_to(now_ns) and not timer.is_queued:
                timer.is_queued = True
                self._queue(timer, partial(_call, timer, timer.life))

    def _queue(self, timer: RosTimer, call: Callable[[], object]) -> None:
        queue = partial(self._call_soon, call)
        if self._conductor is None:
            queue()
        else:
            # Set by the executor of a recorded program.
            number: int = getattr(timer.machine, "number", -1)
            self._conductor.come_in(Kind.TIMER_OP, (number, TimerOp.DUE), b"", queue)

    def _start(self, timer: RosTimer) -> None:
        self._stop(timer)
        timer.is_running = True
        if not self._is_simulated:
            timer.machine.reset()
        elif self._is_heard:
            timer.deadline_ns = self._clock.now_ns() + timer.machine.period_ns

    def _stop(self, timer: RosTimer) -> None:
        timer.machine.cancel()
        timer.is_running = timer.is_queued = False
        timer.deadline_ns = None
        timer.life += 1


def _call(timer: RosTimer, life: int) -> None:
    if timer.life == life:
        timer.is_queued = False
        timer.machine.callback()
