"""The only readers of time. Everything else is given a clock, so that tests can turn it."""

import threading
import time
from typing import Protocol

from rosbase.messages import Time

__all__ = ["Clock", "SystemClock"]


class Clock(Protocol):
    """Tells the time, in two ways, and waits."""

    def now(self) -> Time:
        """The date, for stamps. It may be set, so it may jump."""
        ...

    def now_ns(self) -> int:
        """The date in nanoseconds since the Unix epoch."""
        ...

    def monotonic_ns(self) -> int:
        """Nanoseconds from an arbitrary start; never goes back. For intervals and deadlines."""
        ...

    def wait(self, wakeup: threading.Lock, timeout_s: float) -> bool:
        """Blocks until `wakeup` can be taken, or until the time is up.

        Args:
            wakeup: A lock that another thread releases to end the wait.
            timeout_s: The longest wait; negative means without end.

        Returns:
            Whether the lock was taken.
        """
        ...


class SystemClock:
    """The clock of this machine."""

    now_ns = staticmethod(time.time_ns)
    monotonic_ns = staticmethod(time.monotonic_ns)

    def now(self) -> Time:
        """The date, for stamps."""
        return Time.from_nanoseconds(time.time_ns())

    def wait(self, wakeup: threading.Lock, timeout_s: float) -> bool:
        """Blocks until `wakeup` can be taken, or until the time is up."""
        if timeout_s < 0:
            return wakeup.acquire()
        return wakeup.acquire(timeout=min(timeout_s, threading.TIMEOUT_MAX))
