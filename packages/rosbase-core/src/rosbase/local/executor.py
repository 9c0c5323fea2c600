"""Runs callbacks on one thread: those handed over by others, and those of timers."""

import heapq
import threading
from collections import deque
from collections.abc import Callable
from itertools import count

from rosbase.clock import Clock

__all__ = ["Executor", "LocalTimer"]

_NS_PER_S = 1_000_000_000


class LocalTimer:
    """A timer with absolute deadlines. Periods that were missed are skipped."""

    __slots__ = ("_callback", "_executor", "_period_ns", "_serial")

    def __init__(
        self, executor: "Executor", period_ns: int, callback: Callable[[], object]
    ) -> None:
        self._executor = executor
        self._period_ns = period_ns
        self._callback = callback
        # Names the entry of the heap that counts; any other is of a life before.
        self._serial: int | None = None

    def cancel(self) -> None:
        """Stops it, until `reset`."""
        self._serial = None

    def reset(self) -> None:
        """Starts it again: the next call is one period from now."""
        now_ns = self._executor.clock.monotonic_ns()
        self._serial = self._executor.schedule_timer(now_ns + self._period_ns, self)

    def is_canceled(self) -> bool:
        """Whether it is stopped."""
        return self._serial is None

    def fire(self, serial: int, deadline_ns: int) -> None:
        """Calls back, if the entry still counts, after setting the next deadline."""
        if serial != self._serial:
            return
        late_ns = self._executor.clock.monotonic_ns() - deadline_ns
        periods = 1 + max(0, late_ns // self._period_ns)
        self._serial = self._executor.schedule_timer(deadline_ns + periods * self._period_ns, self)
        self._callback()


class Executor:
    """A queue of calls and a heap of timers; one thread runs both."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._ready: deque[Callable[[], object]] = deque()
        self._timers: list[tuple[int, int, LocalTimer]] = []
        self._timer_lock = threading.Lock()
        self._serials = count(1)
        # Held while nobody has called. Released to wake the spinning thread.
        self._wakeup = threading.Lock()
        self._wakeup.acquire()
        self._sleeping = False

    def call_soon(self, function: Callable[[], object]) -> None:
        """Queues a call. Takes no lock, so that a signal handler may do it too."""
        self._ready.append(function)
        if self._sleeping:
            try:
                self._wakeup.release()
            except RuntimeError:
                # Somebody else has just done it.
                pass

    def schedule_timer(self, deadline_ns: int, timer: LocalTimer) -> int:
        """Has the timer fire at the deadline; gives the entry's serial number."""
        serial = next(self._serials)
        with self._timer_lock:
            heapq.heappush(self._timers, (deadline_ns, serial, timer))
        if self._sleeping:
            self.call_soon(_nothing)
        return serial

    def spin_once(self, timeout_s: float) -> bool:
        """Runs one call, waiting for it as long as `timeout_s`; tells whether there was one."""
        if self._run_one():
            return True
        deadline_ns = self.clock.monotonic_ns() + int(timeout_s * _NS_PER_S)
        while (left_ns := deadline_ns - self.clock.monotonic_ns()) > 0:
            self._sleep(left_ns)
            if self._run_one():
                return True
        return False

    def spin_until(self, deadline_ns: int, stopping: Callable[[], bool]) -> None:
        """Runs calls until the deadline; those that are ready now, even if it has passed."""
        for _ in range(len(self._ready) + len(self._timers)):
            if stopping() or not self._run_one():
                break
        while not stopping() and (left_ns := deadline_ns - self.clock.monotonic_ns()) > 0:
            if not self._run_one():
                self._sleep(left_ns)

    def clear(self) -> None:
        """Drops everything that waits to be run."""
        self._ready.clear()
        with self._timer_lock:
            self._timers.clear()

    def _run_one(self) -> bool:
        # Timers first: they are few, and a flood of messages must not starve them.
        due = self._pop_due_timer() if self._timers else None
        if due is not None:
            deadline_ns, serial, timer = due
            timer.fire(serial, deadline_ns)
            return True
        if self._ready:
            self._ready.popleft()()
            return True
        return False

    def _pop_due_timer(self) -> tuple[int, int, LocalTimer] | None:
        now_ns = self.clock.monotonic_ns()
        with self._timer_lock:
            if self._timers and self._timers[0][0] <= now_ns:
                return heapq.heappop(self._timers)
        return None

    def _sleep(self, limit_ns: int) -> None:
        self._sleeping = True
        # Looked at only now: whoever came before this line did not see us sleep.
        with self._timer_lock:
            if self._timers:
                limit_ns = min(limit_ns, self._timers[0][0] - self.clock.monotonic_ns())
        if not self._ready and limit_ns > 0:
            self.clock.wait(self._wakeup, limit_ns / _NS_PER_S)
        self._sleeping = False


def _nothing() -> None:
    """What is called to wake the spinning thread for a new timer."""
