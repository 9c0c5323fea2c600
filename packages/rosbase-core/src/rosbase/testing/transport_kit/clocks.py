"""Clocks that show which clock a transport reads, and how it reacts to a failure."""

import threading

from rosbase.clock import SystemClock

__all__ = ["FailingClock", "ShiftedClock", "SteppingClock"]

_HOUR_NS = 3_600_000_000_000


class ShiftedClock(SystemClock):
    """System clock, an hour behind; its monotonic time is two hours ahead."""

    @staticmethod
    def now_ns() -> int:
        """Return the date an hour ago."""
        return SystemClock.now_ns() - _HOUR_NS

    @staticmethod
    def monotonic_ns() -> int:
        """Return the monotonic time of the system in two hours."""
        return SystemClock.monotonic_ns() + 2 * _HOUR_NS


class SteppingClock(SystemClock):
    """System clock whose date the test sets."""

    def __init__(self) -> None:
        """Start with the correct date."""
        self.ahead_ns = 0
        """Offset of the date to the system's."""

    def now_ns(self) -> int:
        """Return the date."""
        return SystemClock.now_ns() + self.ahead_ns


class FailingClock(SystemClock):
    """Clock that raises, if told to, on every thread that is newer than the clock."""

    def __init__(self) -> None:
        """Start without a failure."""
        self.failure: BaseException | None = None
        """Exception that it raises; None while it works."""
        self._spared = set(threading.enumerate())

    def now_ns(self) -> int:
        """Return the date."""
        self._fail()
        return SystemClock.now_ns()

    def monotonic_ns(self) -> int:
        """Return the monotonic time of the system."""
        self._fail()
        return SystemClock.monotonic_ns()

    def _fail(self) -> None:
        if self.failure is not None and threading.current_thread() not in self._spared:
            raise self.failure
