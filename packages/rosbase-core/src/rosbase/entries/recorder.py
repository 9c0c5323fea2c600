"""The recorder: numbers everything that runs in a program, and notes what comes from outside."""

import os
import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Any, TypeVar
from weakref import WeakSet

from attrs import define

from rosbase.clock import Clock
from rosbase.entries.conductor import Play
from rosbase.entries.kinds import HAS_PAYLOAD, SECTION_OPS, Kind, Numbered
from rosbase.entries.log_entrance import LogEntrance
from rosbase.entries.outcomes import error_to_json
from rosbase.entries.payloads import Json, Payload, to_json
from rosbase.entries.recorded_clock import RecordedClock
from rosbase.entries.recorded_executor import RecordedExecutor
from rosbase.entries.sink import IN_PROCESS, EndFacts, RecordingSink, RunFacts
from rosbase.entries.trace import Trace
from rosbase.entries.turn import Turn

__all__ = ["Recorder"]

T = TypeVar("T")

# So that the main loop does not wait for long for a thread that brings others' items in.
_MOST_AT_ONCE = 8
_ALL = 1 << 62
# Of items that wait for the turn. Then a frame waits too, as it does in the kernel.
_MOST_ITEMS = 65_536
_PATIENCE_S = 1.0
_OUTSIDE = -1


_recorders: "WeakSet[Recorder]" = WeakSet()


@define
class _Item:
    """Something from outside that waits for the turn."""

    kind: Kind
    numbers: tuple[int, ...]
    payload: Payload
    run: Callable[[], object]
    error: Exception | None = None


class Recorder:
    """Records the entries of one program. The thread that builds it holds the turn from now on."""

    is_replay = False
    is_of_middleware = False

    def __init__(
        self,
        machine: Clock,
        sink: RecordingSink | None = None,
        facts: dict[str, Any] | None = None,
    ) -> None:
        """Begin the first entry.

        Args:
            machine: The clock that the program would have without a recording.
            sink: Writes the recording. Without one, it stays in `trace`.
            facts: What else is known of the run.
        """
        self.turn = Turn()
        self.trace = Trace()
        """Where entries are noted."""
        self.clock = RecordedClock(machine, self, self.turn, self.trace)
        self._log = LogEntrance(self, self.clock.log_now_ns)
        self.spoiled: list[str] = []
        """Why the run cannot be replayed to its end."""
        self._sink = sink
        self._facts = facts or {}
        self._monotonic_ns = machine.monotonic_ns
        self._start_ns = self.clock.start_ns
        self._sleep = machine.sleep
        self._inbox: deque[_Item] = deque()
        self._executor: RecordedExecutor | None = None
        self._counts = {what: count() for what in Numbered}
        # Whether an item is being brought in, by the holder of the turn.
        self._is_bringing_in = False
        self._is_over = False
        self.turn.acquire()
        self.trace.begin(Kind.BEGIN, 0)
        _recorders.add(self)

    @property
    def is_inside(self) -> bool:
        """Whether the calling thread runs the program now."""
        return self.turn.is_mine

    @property
    def has_waiting(self) -> bool:
        """Whether something from outside waits for the turn."""
        return bool(self._inbox)

    def make_executor(self) -> RecordedExecutor:
        """Return the executor of the program; called once."""
        self._executor = RecordedExecutor(self.clock, self)
        return self._executor

    def record_into(self, sink: RecordingSink) -> None:
        """Have that sink write the recording; call it before `begin`."""
        self._sink = sink

    def begin(self, backend: Any) -> None:
        """Let the sink listen to the program."""
        self._log.begin()
        if self._sink is not None:
            clock = self.clock
            more = {**self._facts, IN_PROCESS: backend.delivers_in_process}
            facts = RunFacts(clock.start_date_ns, clock.start_ns, more)
            self._sink.begin(backend, self, self.trace, facts)

    def end(self, error: BaseException | None) -> None:
        """End the recording. What comes from outside from now on comes in without it."""
        if self._is_over:
            return
        if not (self.turn.is_mine or self.turn.acquire(_PATIENCE_S)):
            # The thread that has built the program may be elsewhere for ever.
            self.turn.take_over()
        self.bring_in()
        self.enter_now(Kind.END)
        self._is_over = True
        # Also of threads that had not seen the end.
        self.bring_in()
        self._log.end()
        self.turn.release()
        if self._sink is not None:
            ended_by = f"{type(error).__name__}: {error}" if error is not None else ""
            self._sink.close(EndFacts(self.trace.number + 1, ended_by, list(self.spoiled)))

    def forget(self) -> None:
        """Record nothing more. Called in a forked child, where no thread writes."""
        self._is_over = True
        self.turn.forget()

    # Inside.

    def enter_now(self, kind: int, *numbers: int, payload: Payload | None = None) -> None:
        """Begin an entry: what the thread inside does from now on belongs to it."""
        if not self._is_over:
            now_ns = self._monotonic_ns() - self._start_ns
            self.trace.begin(kind, now_ns, *numbers, payload=payload)

    def number(self, what: Numbered, text: str, play: Play | None = None) -> int:
        """Return the number of something that the program creates; -1 for a thread outside."""
        if not self.turn.is_mine:
            if not self._is_over:
                thread = threading.current_thread().name
                self.spoil(f"thread {thread!r} created a {what.name.lower()}: {text}")
            return _OUTSIDE
        number = next(self._counts[what])
        self.trace.note(Kind.NEW, what, number, payload=text.encode("utf-8", "replace"))
        return number

    def note_period(self, what: Numbered, number: int, period_ns: int) -> None:
        """Note how often something runs that the program has created."""
        if number != _OUTSIDE:
            self.trace.note(Kind.PERIOD, what, number, period_ns)

    def register(self, kind: Kind, play: Play) -> None:
        """Do nothing: only a replay plays."""

    def fact(self, read: Callable[[], Json]) -> Json:
        """Return what the program asks about something outside, and note it."""
        value = read()
        if self.turn.is_mine:
            self.trace.note(Kind.FACT, payload=to_json(value))
        return value

    def section(self, transport: int, op: str, call: Callable[[], Json]) -> Json:
        """Call a transport with the turn free, and note its result or its error."""
        if not self.turn.is_mine:
            return call()
        numbers = (transport, SECTION_OPS.index(op))
        try:
            # A frame that is being handed over is to end before anything else runs.
            value = call() if self._is_bringing_in else self._call_with_turn_free(call)
        except Exception as error:
            self.enter_now(Kind.SECTION, *numbers, 0, payload=to_json(error_to_json(error)))
            raise
        self.enter_now(Kind.SECTION, *numbers, 1, payload=to_json(value))
        return value

    def aside(self, call: Callable[[], object]) -> None:
        """Run upkeep with the turn free."""
        if self.turn.is_mine:
            self.let_go(call)
        else:
            call()

    def nap(self, seconds: float) -> None:
        """Sleep with the turn free, and bring in what has come meanwhile."""
        self.turn.release()
        try:
            if not self._inbox:
                self._sleep(seconds)
        finally:
            self.turn.acquire()
        self.bring_in()

    def let_go(self, call: Callable[[], T]) -> T:
        """Call something with the turn free, and return its result."""
        self.turn.release()
        try:
            return call()
        finally:
            self.turn.acquire()

    def bring_in(self, most: int = _ALL) -> None:
        """Bring in what waits, in its order. Only for the holder of the turn."""
        inbox, before = self._inbox, self._is_bringing_in
        if not inbox:
            return
        self._is_bringing_in = True
        try:
            while inbox and most > 0:
                most -= 1
                self._bring_in(inbox.popleft())
        finally:
            self._is_bringing_in = before

    # Outside.

    def come_in(
        self, kind: Kind, numbers: tuple[int, ...], payload: Payload, run: Callable[[], object]
    ) -> None:
        """Let something from outside come in as an entry; inside, it runs at once."""
        if self._is_over or self.turn.is_mine:
            run()
            return
        item = _Item(kind, numbers, payload, run)
        if len(self._inbox) >= _MOST_ITEMS:
            self._make_room(kind)
        self._inbox.append(item)
        if self.turn.try_acquire():
            try:
                self.bring_in(_MOST_AT_ONCE)
            finally:
                self.turn.release()
        # Also what came while this thread had the turn, and nobody else could bring it in.
        if self._inbox:
            self._wake()
        if item.error is not None:
            raise item.error

    def come_in_later(self, kind: Kind, run: Callable[[], object]) -> None:
        """Queue an item and do nothing else, because a signal handler may interrupt anything."""
        if self._is_over:
            run()
            return
        self._inbox.append(_Item(kind, (), b"", run))
        self._wake()

    def enter(
        self, kind: Kind, numbers: tuple[int, ...], payload: Payload, run: Callable[[], T]
    ) -> T:
        """Run something from outside as an entry, when the turn is free, and return its result."""
        if self._is_over or self.turn.is_mine:
            return run()
        if not self.turn.acquire(_PATIENCE_S):
            self.spoil(f"{kind.name} came in while an entry ran for more than {_PATIENCE_S:g} s")
            return run()
        try:
            self.bring_in()
            self._begin(kind, numbers, payload)
            return run()
        finally:
            self.turn.release()
            if self._inbox:
                self._wake()

    def spoil(self, reason: str) -> None:
        """Note that the run cannot be replayed from here on."""
        self.spoiled.append(reason)
        text = reason.encode("utf-8", "replace")
        if self.turn.is_mine:
            self._note_spoiled(text)
        elif not self._is_over:
            self._inbox.append(_Item(Kind.SPOIL, (), text, partial(self._note_spoiled, text)))

    # Own.

    def _begin(self, kind: Kind, numbers: tuple[int, ...], payload: Payload) -> None:
        self.enter_now(kind, *numbers, payload=payload if kind in HAS_PAYLOAD else None)

    def _call_with_turn_free(self, call: Callable[[], T]) -> T:
        try:
            return self.let_go(call)
        finally:
            self.bring_in()

    def _bring_in(self, item: _Item) -> None:
        if item.kind is not Kind.SPOIL:
            self._begin(item.kind, item.numbers, item.payload)
        try:
            item.run()
        except Exception as error:
            # Whoever has brought it raises it, if that is this thread.
            item.error = error
            self.spoil(f"{item.kind.name} raised {type(error).__name__}: {error}")

    def _note_spoiled(self, reason: bytes) -> None:
        self.trace.note(Kind.SPOIL, self._monotonic_ns() - self._start_ns, payload=reason)

    def _make_room(self, kind: Kind) -> None:
        if kind is Kind.FRAME and self.turn.acquire(_PATIENCE_S):
            try:
                self.bring_in()
            finally:
                self.turn.release()

    def _wake(self) -> None:
        if self._executor is not None:
            self._executor.wake()


def _forget_in_child() -> None:
    for recorder in list(_recorders):
        recorder.forget()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_in_child)
