"""A clock whose readings are noted, so that a replay reads the same."""

import threading
from collections.abc import Callable
from threading import get_ident
from typing import TYPE_CHECKING, Any

from rosbase.clock import Clock
from rosbase.entries.kinds import Kind
from rosbase.entries.trace import Trace
from rosbase.entries.turn import Turn
from rosbase.messages import Time

if TYPE_CHECKING:
    from rosbase.entries.conductor import Conductor

__all__ = ["RecordedClock"]


class RecordedClock:
    """Reads another clock. Inside the program, each reading is noted."""

    def __init__(self, machine: Clock, conductor: "Conductor", turn: Turn, trace: Trace) -> None:
        """Start the time of the run now.

        Args:
            machine: The clock to read.
            conductor: The recorder of the program.
            turn: Whether a reading is inside the program.
            trace: Where readings are noted.
        """
        self.conductor = conductor
        self._turn, self._trace = turn, trace
        self.start_ns = machine.monotonic_ns()
        """Monotonic time of the start of the run."""
        self.start_date_ns = machine.now_ns()
        """Date of the start of the run, in nanoseconds since the Unix epoch."""
        self.log_now_ns = _noted(machine.now_ns, Kind.READ_LOG, self.start_date_ns, turn, trace)
        """Return the date for a log record."""
        self._read(machine)

    def beside(self, machine: Clock) -> "RecordedClock":
        """Return a clock of the same program that reads another one, such as a node's."""
        other = object.__new__(RecordedClock)
        vars(other).update(vars(self))
        other._read(machine)
        return other

    def now(self) -> Time:
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(self.now_ns())

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """Return a function that waits for a lock, for a limited number of seconds."""
        return self.machine.waiter(wakeup)

    def _read(self, machine: Clock) -> None:
        turn, trace = self._turn, self._trace
        self.machine = machine
        """The clock that it reads, for code outside of the program."""
        read = _noted(machine.monotonic_ns, Kind.READ_MONO, self.start_ns, turn, trace)
        self.monotonic_ns = read
        self.now_ns = _noted(machine.now_ns, Kind.READ_DATE, self.start_date_ns, turn, trace)
        self.suspended_ns = _noted(machine.suspended_ns, Kind.READ_SLEPT, 0, turn, trace)
        self.sleep = machine.sleep

    if not TYPE_CHECKING:  # to a type checker, it would have every attribute

        def __getattr__(self, name: str) -> Any:
            """Return an attribute of the clock itself, such as `advance` of ManualClock."""
            return getattr(self.machine, name)


def _noted(
    read: Callable[[], int], kind: Kind, origin: int, turn: Turn, trace: Trace
) -> Callable[[], int]:
    """Return a function that reads a clock, and notes the value less `origin`."""
    code, note = int(kind), trace.ints.extend

    def read_and_note() -> int:
        value = read()
        if turn.owner == get_ident():
            note((code, value - origin))
        return value

    return read_and_note
