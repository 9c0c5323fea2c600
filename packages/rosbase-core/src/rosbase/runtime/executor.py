"""Run callbacks on one thread: calls from other threads, and timers.

Urgent calls are the ones that also run while that thread waits for something in one of its
callbacks (`wait`), such as the answer of a service. All others wait until it spins again.
"""

import heapq
import threading
from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from itertools import count
from threading import get_ident
from typing import TypeAlias

from rosbase.clock import Clock
from rosbase.errors import BackendError

__all__ = ["Description", "Executor", "ExecutorTimer", "GuestCall"]

_NS_PER_S = 1_000_000_000
_FEW_ENTRIES = 64
_LONGEST_S = 1e6
_FOR_EVER_NS = 1 << 62


Description: TypeAlias = tuple[int, tuple[int, ...], bytes | Callable[[], bytes]]
"""Kind of an entry, its numbers, and its payload."""


class ExecutorTimer:
    """A timer with absolute deadlines. Missed periods are skipped."""

    __slots__ = ("_executor", "callback", "is_destroyed", "period_ns", "serial")

    def __init__(
        self, executor: "Executor", period_ns: int, callback: Callable[[], object]
    ) -> None:
        self._executor = executor
        self.period_ns = period_ns
        self.callback = callback
        self.is_destroyed = False
        """Whether the timer is destroyed, so that it does not start again."""
        self.serial: int | None = None
        """Number of the valid entry in the executor's heap; all others are outdated."""

    def cancel(self) -> None:
        """Stop the timer, until `reset`."""
        self._executor.cancel_timer(self)

    def reset(self) -> None:
        """Restart the timer: the next call is one period from now."""
        self._executor.start_timer(self)

    def is_canceled(self) -> bool:
        """Return whether the timer is stopped."""
        return self.serial is None

    def destroy(self) -> None:
        """Stop the timer for good."""
        self._executor.cancel_timer(self, destroy=True)


class GuestCall:
    """A queued call of which the main loop does not conclude that others will follow."""

    __slots__ = ("_function",)

    def __init__(self, function: Callable[[], object]) -> None:
        self._function = function

    def __call__(self) -> object:
        """Make the call."""
        return self._function()


class Executor:
    """A queue of calls and a heap of timers; one thread runs both."""

    __slots__ = (
        "_cleans_up",
        "_closed",
        "_compact_at",
        "_monotonic_ns",
        "_owes_a_call",
        "_serials",
        "_sleeping",
        "_stopping",
        "_thread_id",
        "_timer_lock",
        "_urgent",
        "_wait",
        "_waits_end_ns",
        "_wakeup",
        "clock",
        "depth",
        "ready",
        "timers",
    )

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._monotonic_ns = clock.monotonic_ns
        self.ready: deque[Callable[[], object]] = deque()
        """Waiting calls. Other code may check whether there is one."""
        # The heap and the serials of its timers; `call_soon` does without this lock.
        self._timer_lock = threading.Lock()
        self.timers: list[tuple[int, int, ExecutorTimer]] = []
        """Heap of timers by deadline, with outdated entries. Other code may look at it."""
        self._serials = count(1)
        self._compact_at = _FEW_ENTRIES
        self._owes_a_call = False
        # Held while nobody has called. Released to wake the spinning thread.
        self._wakeup = threading.Lock()
        self._wakeup.acquire()
        self._wait = clock.waiter(self._wakeup)
        self._sleeping = False
        self._closed = False
        self._urgent: deque[Callable[[], object]] = deque()
        self.depth = 0
        """Number of waits in progress, each within a callback that runs in the one before."""
        self._waits_end_ns = _FOR_EVER_NS
        # Until somebody spins, whoever has made it.
        self._thread_id = get_ident()
        self._stopping: Callable[[], object] = _never
        self._cleans_up = False

    @property
    def is_on_own_thread(self) -> bool:
        """Whether the caller is on the thread that spins, or that has made this executor.

        A thread counts as spinning from its first `spin_until`, or `spin_once` with nothing to run.
        """
        return self._thread_id == get_ident()

    @property
    def is_stopping(self) -> bool:
        """Whether the program was asked to stop, so that nobody should wait any more.

        On the spinning thread it is false again during the clean-up.
        """
        return bool(self._stopping()) and not (self._cleans_up and self.is_on_own_thread)

    def begin(self, stopping: Callable[[], object]) -> None:
        """Note that this thread runs the program until `stopping` returns true."""
        self._thread_id = get_ident()
        self._stopping, self._cleans_up = stopping, False

    def begin_clean_up(self) -> None:
        """Let the spinning thread wait again, although the program is stopping."""
        self._cleans_up = True

    def call_soon(self, function: Callable[[], object]) -> None:
        """Queue a call. It takes no lock, so that a signal handler may do it too."""
        self.ready.append(function)
        if self._sleeping:
            try:
                self._wakeup.release()
            except RuntimeError:
                # Somebody else has just done it.
                pass

    def call_as_guest(self, function: Callable[[], object]) -> None:
        """Queue a call from outside of the program, of which there will be few.

        After such a call, the main loop sleeps as before; see `run_main_loop`. The call may come
        some milliseconds late.
        """
        self.call_soon(GuestCall(function))

    def call_from_outside(
        self, function: Callable[[], object], describe: Callable[[], Description]
    ) -> None:
        """Queue a call as `call_as_guest`; a recording also has the content of the request.

        Args:
            function: The call.
            describe: Returns the content, only while the program is recorded: the kind of the
                entry, its numbers and its payload (`rosbase.entries`).
        """
        self.call_as_guest(function)

    def call_aside(self, function: Callable[[], object]) -> None:
        """Queue upkeep of a backend, of which no callback of the program knows."""
        self.call_soon(function)

    def stop_soon(self, function: Callable[[], object]) -> None:
        """Call a function that requests a stop: at once, or in a recording once it may come in."""
        function()

    def in_signal(self, function: Callable[[], object]) -> None:
        """Call a function in a signal handler, which may have interrupted anything."""
        function()

    def let_others(self) -> AbstractContextManager[None]:
        """Return a context in which a thread other than the spinning one may wait for it."""
        return nullcontext()

    def call_urgently(self, function: Callable[[], object]) -> None:
        """Queue a call that runs even during `wait`. It takes no lock, as `call_soon`."""
        self._urgent.append(function)
        # While nobody waits, it takes its turn among the other calls.
        self.call_soon(self._run_urgent)

    def wake(self) -> None:
        """End the sleep of the spinning thread, so that it looks again. Call it from anywhere."""
        if self._sleeping:
            try:
                self._wakeup.release()
            except RuntimeError:
                # Somebody else has just done it.
                pass

    @property
    def waits_end_ns(self) -> int:
        """Deadline of the waits in progress, on the monotonic clock; far away without one."""
        return self._waits_end_ns

    def wait(
        self, done: Callable[[], object], deadline_ns: int, look_s: float = _LONGEST_S
    ) -> None:
        """Run urgent calls, and nothing else, until `done` returns true or the deadline.

        For the spinning thread, in a callback. Whoever makes `done` true must also call `wake`, or
        it is called again every `look_s`. It also returns when the program is to stop, and at the
        deadline of a wait around it.
        """
        outer_ns = self._waits_end_ns
        self._waits_end_ns = deadline_ns = min(deadline_ns, outer_ns)
        self.depth += 1
        try:
            while not done() and not self.is_stopping:
                left_ns = deadline_ns - self._monotonic_ns()
                if left_ns <= 0:
                    return
                if self._run_urgent_in_wait():
                    continue
                self._sleeping = True
                # Looked at only now: whoever came before this line did not see us sleep.
                if not (self._urgent or done() or self.is_stopping):
                    self._wait(min(left_ns / _NS_PER_S, look_s))
                self._sleeping = False
        finally:
            self._sleeping = False
            self._waits_end_ns = outer_ns
            self.depth -= 1

    def create_timer(self, period_ns: int, callback: Callable[[], object]) -> ExecutorTimer:
        """Create a running timer; the first call is one period from now.

        Raises:
            BackendError: The executor is closed.
        """
        if self._closed:
            raise BackendError("the backend is closed")
        timer = self._new_timer(period_ns, callback)
        timer.reset()
        return timer

    def start_timer(self, timer: ExecutorTimer) -> None:
        """Make the timer fire one period from now, and again after each period."""
        deadline_ns = self._monotonic_ns() + timer.period_ns
        with self._timer_lock:
            if timer.is_destroyed or self._closed:
                return
            self._push(deadline_ns, timer)
        self.wake()

    def cancel_timer(self, timer: ExecutorTimer, *, destroy: bool = False) -> None:
        """Stop the timer from firing; with `destroy`, even if it is reset."""
        with self._timer_lock:
            timer.serial = None
            timer.is_destroyed = timer.is_destroyed or destroy

    def spin_once(self, timeout_s: float) -> bool:
        """Run one call, waiting up to `timeout_s` for it; return whether there was one."""
        if self._run_one(self._monotonic_ns()):
            return True
        # Not for each message, because it would cost a twentieth of one.
        self._thread_id = get_ident()
        deadline_ns = self._monotonic_ns() + int(min(timeout_s, _LONGEST_S) * _NS_PER_S)
        while (left_ns := deadline_ns - self._monotonic_ns()) > 0:
            self._sleep(left_ns)
            if self._run_one(self._monotonic_ns()):
                return True
        return False

    def spin_until(self, deadline_ns: int, stopping: Callable[[], object]) -> None:
        """Run calls until the deadline; run the ready ones even if it has passed.

        Ends at once when `stopping` returns true. It is called before each wait and after
        each call.
        """
        monotonic_ns, ready = self._monotonic_ns, self.ready
        self._thread_id = get_ident()
        # What is due now has its turn, also in a loop that is always late; what becomes due
        # meanwhile waits until after the next tick.
        now_ns = monotonic_ns()
        for _ in range(len(ready) + sum(entry[0] <= now_ns for entry in self.timers)):
            if stopping():
                return
            if not self._run_one(now_ns):
                break
        if stopping():
            return
        while (left_ns := deadline_ns - monotonic_ns()) > 0:
            if (ready or self.timers) and self._run_one(monotonic_ns()):
                if stopping():
                    return
            else:
                self._sleep(left_ns)

    def close(self) -> None:
        """Drop all waiting calls; timers do not start again."""
        self.ready.clear()
        self._urgent.clear()
        with self._timer_lock:
            self._closed = True
            for _, _, timer in self.timers:
                timer.serial = None

    def _new_timer(self, period_ns: int, callback: Callable[[], object]) -> ExecutorTimer:
        return ExecutorTimer(self, period_ns, callback)

    def _run_urgent(self) -> None:
        """Run an urgent call, unless a wait has run it."""
        if self._urgent:
            self._urgent.popleft()()

    def _run_urgent_in_wait(self) -> bool:
        """Run an urgent call if there is one, and return whether there was."""
        if not self._urgent:
            return False
        self._urgent.popleft()()
        return True

    def _run_one(self, due_ns: int) -> bool:
        """Run a call, or a timer that was due by then; return whether there was one."""
        # A timer and a call take turns, so that neither a flood of messages nor a timer that
        # is always late starves the other.
        if self.ready and self._owes_a_call:
            self._owes_a_call = False
            self.ready.popleft()()
            return True
        timer = self._take_due_timer(due_ns) if self.timers else None
        if timer is not None:
            self._owes_a_call = True
            timer.callback()
            return True
        if self.ready:
            self.ready.popleft()()
            return True
        return False

    def _take_due_timer(self, due_ns: int) -> ExecutorTimer | None:
        """Return the first timer that was due by then, after setting its next deadline."""
        now_ns = self._monotonic_ns()
        with self._timer_lock:
            while self.timers and self.timers[0][0] <= due_ns:
                deadline_ns, serial, timer = heapq.heappop(self.timers)
                if serial == timer.serial:
                    periods = 1 + (now_ns - deadline_ns) // timer.period_ns
                    self._push(deadline_ns + periods * timer.period_ns, timer)
                    return timer
        return None

    def _push(self, deadline_ns: int, timer: ExecutorTimer) -> None:
        timer.serial = next(self._serials)
        heapq.heappush(self.timers, (deadline_ns, timer.serial, timer))
        if len(self.timers) > self._compact_at:
            # A watchdog that is reset by every message leaves an entry behind each time.
            # In place, and never to nothing: the main loop may be looking at it.
            self.timers[:] = [entry for entry in self.timers if entry[1] == entry[2].serial]
            heapq.heapify(self.timers)
            self._compact_at = max(_FEW_ENTRIES, 2 * len(self.timers))

    def _sleep(self, limit_ns: int) -> None:
        self._sleeping = True
        # Looked at only now: whoever came before this line did not see us sleep.
        if self.timers:
            with self._timer_lock:
                if self.timers:
                    limit_ns = min(limit_ns, self.timers[0][0] - self._monotonic_ns())
        if not self.ready and limit_ns > 0:
            self._wait(limit_ns / _NS_PER_S)
        self._sleeping = False


def _never() -> bool:
    """Return false: nobody has asked for a stop."""
    return False
