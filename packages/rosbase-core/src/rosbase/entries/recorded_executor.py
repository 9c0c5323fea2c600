"""The executor of a program that is recorded: it numbers each call and each timer that it runs."""

import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import count
from threading import get_ident
from typing import TYPE_CHECKING

from rosbase.entries.kinds import Kind, Numbered, TimerOp
from rosbase.entries.recorded_clock import RecordedClock
from rosbase.runtime.executor import Description, Executor, ExecutorTimer, GuestCall

if TYPE_CHECKING:
    from rosbase.entries.recorder import Recorder

__all__ = ["RecordedExecutor", "RecordedTimer", "name_of"]

_LONGEST_S = 1e6
# In Python 3.11, to find a member takes 0.2 us.
_CALL, _TIMER = int(Kind.CALL), int(Kind.TIMER)


class RecordedTimer(ExecutorTimer):
    """A timer with a number."""

    __slots__ = ("number",)

    number: int
    """How many timers were created before; -1 if a thread outside has created it."""


class _Poster(threading.local):
    """Number of a thread, and the count of its posted calls."""

    number = -1
    posted = 0


class RecordedExecutor(Executor):
    """Runs calls and timers as `Executor` does, in the turn. While it sleeps, the turn is free."""

    __slots__ = (
        "_asides",
        "_machine_wait",
        "_poster",
        "_signal_thread",
        "_threads",
        "_turn",
        "recorder",
    )

    def __init__(self, clock: RecordedClock, recorder: "Recorder") -> None:
        super().__init__(clock)
        # Its own readings are not the program's.
        self._monotonic_ns = clock.machine.monotonic_ns
        self._machine_wait = self._wait
        self._wait = self._wait_with_turn_free
        self.recorder = recorder
        """Notes what runs."""
        self._turn = recorder.turn
        self._asides: deque[Callable[[], object]] = deque()
        self._poster = _Poster()
        self._threads = count()
        # The thread whose signal handler runs now.
        self._signal_thread = 0

    def begin(self, stopping: Callable[[], object]) -> None:
        """Note that this thread runs the program, and has the turn."""
        self._turn.take_over()
        super().begin(stopping)

    # Calls from anywhere.

    def call_soon(self, function: Callable[[], object]) -> None:
        """Queue a call; one of another thread gets a number."""
        if self._turn.owner == get_ident():
            Executor.call_soon(self, function)
        else:
            self._post(partial(Executor.call_soon, self, function))

    def call_urgently(self, function: Callable[[], object]) -> None:
        """Queue a call that runs even during `wait`."""
        if self._turn.owner == get_ident():
            Executor.call_urgently(self, function)
        else:
            self._post(partial(Executor.call_urgently, self, function))

    def call_from_outside(
        self, function: Callable[[], object], describe: Callable[[], Description]
    ) -> None:
        """Queue a call from outside of the program, with its content."""
        kind, numbers, payload = describe()
        queue = partial(Executor.call_soon, self, GuestCall(function))
        self.recorder.come_in(Kind(kind), numbers, payload, queue)

    def call_aside(self, function: Callable[[], object]) -> None:
        """Queue upkeep, which is no entry."""
        self._asides.append(function)
        self.wake()

    def stop_soon(self, function: Callable[[], object]) -> None:
        """Let a request to stop come in; in a signal handler, only queue it."""
        if self._signal_thread == get_ident():
            self.recorder.come_in_later(Kind.STOP, function)
        else:
            self.recorder.come_in(Kind.STOP, (), b"", function)

    def in_signal(self, function: Callable[[], object]) -> None:
        """Call a function in a signal handler, which may have interrupted an entry."""
        before, self._signal_thread = self._signal_thread, get_ident()
        try:
            function()
        finally:
            self._signal_thread = before

    @contextmanager
    def let_others(self) -> Iterator[None]:
        """Let others run the program while a thread that is inside, but not ours, waits."""
        if not self._turn.is_mine:
            yield
            return
        self.recorder.spoil("a thread other than the main loop's waited within an entry")
        self._turn.release()
        try:
            yield
        finally:
            self._turn.acquire()

    # Timers.

    def start_timer(self, timer: ExecutorTimer) -> None:
        """Restart a timer; another thread's request comes in when the turn is free."""
        self._operate(timer, TimerOp.RESET, partial(Executor.start_timer, self, timer))

    def cancel_timer(self, timer: ExecutorTimer, *, destroy: bool = False) -> None:
        """Stop a timer; another thread's request comes in when the turn is free."""
        op = TimerOp.DESTROY if destroy else TimerOp.CANCEL
        self._operate(timer, op, partial(Executor.cancel_timer, self, timer, destroy=destroy))

    # The thread that spins.

    def spin_once(self, timeout_s: float) -> bool:
        """Run one call, waiting up to `timeout_s` for it; return whether there was one."""
        self._catch_up()
        has_run = super().spin_once(timeout_s)
        self.recorder.enter_now(Kind.RETURN, has_run)
        return has_run

    def spin_until(self, deadline_ns: int, stopping: Callable[[], object]) -> None:
        """Run calls until the deadline; run the ready ones even if it has passed."""
        self._catch_up()
        super().spin_until(deadline_ns, stopping)
        self.recorder.enter_now(Kind.RETURN, 0)

    def wait(
        self, done: Callable[[], object], deadline_ns: int, look_s: float = _LONGEST_S
    ) -> None:
        """Run urgent calls, and nothing else, until `done` returns true or the deadline."""
        super().wait(done, deadline_ns, look_s)
        self.recorder.enter_now(Kind.RETURN, 0)

    def _run_urgent_in_wait(self) -> bool:
        self.recorder.bring_in()
        if not self._urgent:
            return False
        call = self._urgent.popleft()
        self.recorder.enter_now(Kind.URGENT)
        call()
        return True

    def _run_one(self, due_ns: int) -> bool:
        recorder = self.recorder
        if self._asides or recorder.has_waiting:
            self._catch_up()
        # As in the base class, with a number for each.
        if not (self.ready and self._owes_a_call):
            timer = self._take_due_timer(due_ns) if self.timers else None
            if timer is not None:
                self._owes_a_call = True
                recorder.enter_now(_TIMER, timer.number)  # type: ignore[attr-defined]  # ours
                timer.callback()
                return True
            if not self.ready:
                return False
        else:
            self._owes_a_call = False
        call = self.ready.popleft()
        recorder.enter_now(_CALL)
        call()
        return True

    def _wait_with_turn_free(self, timeout_s: float) -> bool:
        recorder = self.recorder
        self._turn.release()
        try:
            # Looked at only now: whoever came before this line found the turn taken.
            is_called = bool(self._asides) or recorder.has_waiting or self._machine_wait(timeout_s)
        finally:
            self._turn.acquire()
        recorder.bring_in()
        return is_called

    # Others.

    def _catch_up(self) -> None:
        while self._asides:
            self.recorder.let_go(self._asides.popleft())
        self.recorder.bring_in()

    def _new_timer(self, period_ns: int, callback: Callable[[], object]) -> ExecutorTimer:
        timer = RecordedTimer(self, period_ns, callback)
        timer.number = self.recorder.number(Numbered.TIMER, name_of(callback))
        self.recorder.note_period(Numbered.TIMER, timer.number, period_ns)
        return timer

    def _post(self, queue: Callable[[], object]) -> None:
        poster = self._poster
        if poster.number < 0:
            poster.number = next(self._threads)
            name = threading.current_thread().name.encode("utf-8", "replace")
            queue = partial(self._queue_first, poster.number, name, queue)
        numbers = (poster.number, poster.posted)
        poster.posted += 1
        self.recorder.come_in(Kind.POSTED, numbers, b"", queue)

    def _queue_first(self, number: int, name: bytes, queue: Callable[[], object]) -> None:
        """Queue the first call of a thread, and note the name by which a replay knows it."""
        self.recorder.trace.note(Kind.NEW, Numbered.THREAD, number, payload=name)
        queue()

    def _operate(self, timer: ExecutorTimer, op: TimerOp, operate: Callable[[], object]) -> None:
        number = getattr(timer, "number", -1)
        self.recorder.come_in(Kind.TIMER_OP, (number, op), b"", operate)


def name_of(function: Callable[..., object]) -> str:
    """Return the name of a callback, by which a replay of changed code finds it."""
    while isinstance(function, partial):
        function = function.func
    name = getattr(function, "__qualname__", type(function).__qualname__)
    return str(name)
