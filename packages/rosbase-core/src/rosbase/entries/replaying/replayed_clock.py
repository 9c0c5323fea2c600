"""The clock of a replayed program: it reads what it read when it was recorded."""

import threading
from collections.abc import Callable
from threading import get_ident
from typing import TYPE_CHECKING

from rosbase.clock import SystemClock
from rosbase.entries.replaying.virtual_clock import VirtualClock
from rosbase.entries.script import NO_NOTES, Entry, Notes
from rosbase.entries.turn import Turn
from rosbase.messages import Time

if TYPE_CHECKING:
    from rosbase.entries.replaying.player import Player

__all__ = ["ReplayedClock"]

_MACHINE = SystemClock()
_MOMENT_S = 0.001


class ReplayedClock:
    """Returns the recorded readings of the entry that runs, then the time of the machine.

    On other threads it is the clock of the machine, which stands at the time of the entry.
    """

    def __init__(self, conductor: "Player", machine: VirtualClock, turn: Turn) -> None:
        """Start with no recorded readings.

        Args:
            conductor: The replay.
            machine: The clock below.
            turn: Its holder is the thread that runs the program.
        """
        self.conductor = conductor
        """The replay, for all who ask whether there is one."""
        self.machine = machine
        """The clock of the machine in this replay."""
        self._turn = turn
        # The last entry that has read it, and its readings, which are taken out one by one.
        self._entry: Entry | None = None
        self._notes = NO_NOTES
        self._planned = self._more = 0
        self._is_free = False

    def begin_free(self) -> None:
        """Forget the recorded readings, and read the clock of the machine from now on."""
        self._notes_now()
        self._notes = NO_NOTES
        self._is_free = True

    @property
    def reads(self) -> tuple[int, int]:
        """How often the entry has read the clock so far, and how often it did when recorded."""
        notes = self._notes_now()
        left = len(notes.mono) + len(notes.date)
        return self._planned - left + self._more, self._planned

    def _notes_now(self) -> Notes:
        """Return the recorded readings of the entry that runs."""
        entry = self.conductor.entry
        # Looked at only when the clock is read, because most entries do not read it.
        if entry is not self._entry and not self._is_free:
            self._entry = entry
            notes = self._notes = entry.notes
            self._planned = 0 if notes is NO_NOTES else len(notes.mono) + len(notes.date)
            self._more = 0
        return self._notes

    def now(self) -> Time:
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(self.now_ns())

    def now_ns(self) -> int:
        """Return the date in nanoseconds since the Unix epoch."""
        if self._turn.owner == get_ident():
            notes = self._notes_now()
            if notes.date:
                return self.machine.date_read(notes.date.popleft())
            self._more += 1
            self.machine.look()
        return self.machine.now_ns()

    def log_now_ns(self) -> int:
        """Return the date for a log record."""
        if self._turn.owner == get_ident() and (notes := self._notes_now()).log:
            return self.machine.date_read(notes.log.popleft())
        return self.machine.now_ns()

    def monotonic_ns(self) -> int:
        """Return the monotonic time."""
        if self._turn.owner == get_ident():
            notes = self._notes_now()
            if notes.mono:
                return self.machine.mono_read(notes.mono.popleft())
            self._more += 1
        return self.machine.monotonic_ns()

    def suspended_ns(self) -> int:
        """Return for how long the machine had slept."""
        if self._turn.owner == get_ident() and (notes := self._notes_now()).slept:
            return self.machine.slept_read(notes.slept.popleft())
        return self.machine.suspended_ns()

    def sleep(self, seconds: float) -> None:
        """Return at once: the recorded readings show how long it took.

        A thread of the user sleeps for a moment, so that it does not keep the processor busy.
        """
        if not self._turn.is_mine:
            _MACHINE.sleep(min(seconds, _MOMENT_S))
        elif self._is_free:
            self.machine.sleep(seconds)

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """Return a function that waits for a lock, in virtual time."""

        def wait(timeout_s: float) -> bool:
            if wakeup.acquire(blocking=False):
                return True
            self.sleep(timeout_s)
            return False

        return wait
