"""The clock of a replayed program: it reads what it read when it was recorded."""

import threading
from collections import deque
from collections.abc import Callable
from threading import get_ident
from typing import TYPE_CHECKING

from rosbase.clock import SystemClock
from rosbase.entries.replaying.virtual_clock import VirtualClock
from rosbase.entries.script import Entry
from rosbase.messages import Time

if TYPE_CHECKING:
    from rosbase.entries.conductor import Conductor

__all__ = ["ReplayedClock"]

_NO_READS: deque[int] = deque()
_MACHINE = SystemClock()
_MOMENT_S = 0.001


class ReplayedClock:
    """Returns the recorded readings of the entry that runs, then the time of the machine.

    On other threads it is the clock of the machine, whose time is that of the entry.
    """

    def __init__(self, conductor: "Conductor", machine: VirtualClock) -> None:
        """Start with no recorded readings.

        Args:
            conductor: The replay.
            machine: The clock below.
        """
        self.conductor = conductor
        """The replay, for all who ask whether there is one."""
        self.machine = machine
        """The clock of the machine in this replay."""
        self.thread_id = get_ident()
        """The thread that runs the program."""
        self._mono = self._date = self._slept = self._log = _NO_READS
        self._planned = self._more = 0
        self._sleeps_count = True

    def begin(self, entry: Entry) -> None:
        """Go on with the readings of an entry."""
        self._mono, self._date, self._slept = entry.reads_mono, entry.reads_date, entry.reads_slept
        self._log = entry.reads_log
        self._planned, self._more = len(self._mono) + len(self._date), 0
        self.machine.move_to(entry.t_ns)
        self._sleeps_count = False

    def begin_free(self) -> None:
        """Forget the recorded readings: from now on, the clock is that of the machine."""
        self._mono = self._date = self._slept = self._log = _NO_READS
        self._sleeps_count = True

    @property
    def reads(self) -> tuple[int, int]:
        """How often the entry has read the clock so far, and how often it did when recorded."""
        left = len(self._mono) + len(self._date)
        return self._planned - left + self._more, self._planned

    def now(self) -> Time:
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(self.now_ns())

    def now_ns(self) -> int:
        """Return the date in nanoseconds since the Unix epoch."""
        if get_ident() == self.thread_id:
            if self._date:
                return self.machine.date_read(self._date.popleft())
            self._more += 1
        return self.machine.now_ns()

    def log_now_ns(self) -> int:
        """Return the date for a log record."""
        if self._log and get_ident() == self.thread_id:
            return self.machine.date_read(self._log.popleft())
        return self.machine.now_ns()

    def monotonic_ns(self) -> int:
        """Return the monotonic time."""
        if get_ident() == self.thread_id:
            if self._mono:
                return self.machine.mono_read(self._mono.popleft())
            self._more += 1
        return self.machine.monotonic_ns()

    def suspended_ns(self) -> int:
        """Return for how long the machine had slept."""
        if self._slept and get_ident() == self.thread_id:
            return self.machine.slept_read(self._slept.popleft())
        return self.machine.suspended_ns()

    def sleep(self, seconds: float) -> None:
        """Return at once: the recorded readings show how long it took.

        A thread of the user sleeps for a moment, so that it does not keep the processor busy.
        """
        if get_ident() != self.thread_id:
            _MACHINE.sleep(min(seconds, _MOMENT_S))
        elif self._sleeps_count:
            self.machine.sleep(seconds)

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """Return a function that waits for a lock, in virtual time."""

        def wait(timeout_s: float) -> bool:
            if wakeup.acquire(blocking=False):
                return True
            self.sleep(timeout_s)
            return False

        return wait
