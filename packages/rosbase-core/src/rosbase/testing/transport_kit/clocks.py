"""Clocks that show which clock a transport reads, and what it does when it fails."""

import threading

from rosbase.clock import SystemClock

__all__ = ["FailingClock", "ShiftedClock", "SteppingClock"]

_HOUR_NS = 3_600_000_000_000


class ShiftedClock(SystemClock):
    """Runs as the system's does, an hour behind it, its monotonic time two hours ahead."""

    @staticmethod
    def now_ns() -> int:
        """The date an hour ago."""
        return SystemClock.now_ns() - _HOUR_NS

    @staticmethod
    def monotonic_ns() -> int:
        """What the system's will say in two hours."""
        return SystemClock.monotonic_ns() + 2 * _HOUR_NS


class SteppingClock(SystemClock):
    """The system's clock, whose date is set by the test."""

    def __init__(self) -> None:
        """Be right."""
        self.ahead_ns = 0
        """How far the date is ahead of the system's."""

    def now_ns(self) -> int:
        """Return the date."""
        return SystemClock.now_ns() + self.ahead_ns


class FailingClock(SystemClock):
    """Raises, while it is told to, on every thread but those that were there when it was made."""

    def __init__(self) -> None:
        """Works."""
        self.failure: BaseException | None = None
        """What it raises; None as long as it works."""
        self._spared = set(threading.enumerate())

    def now_ns(self) -> int:
        """The date."""
        self._fail()
        return SystemClock.now_ns()

    def monotonic_ns(self) -> int:
        """As the system's."""
        self._fail()
        return SystemClock.monotonic_ns()

    def _fail(self) -> None:
        if self.failure is not None and threading.current_thread() not in self._spared:
            raise self.failure
