"""The only readers of time. Everything else is given a clock, so that tests can turn it."""

import threading
import time
from collections.abc import Callable
from functools import partial
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

    def suspended_ns(self) -> int:
        """Return for how long the machine has slept, which `monotonic_ns` leaves out."""
        ...

    def sleep(self, seconds: float) -> None:
        """Blocks for that long, whatever other threads do."""
        ...

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """A function that waits for a lock, for so many seconds of this clock at most.

        A loop asks for it once, so that a tick pays for nothing but the waiting.

        Args:
            wakeup: A lock that another thread releases to end a wait.

        Returns:
            `wait(timeout_s)`, which tells whether the lock was taken. The time is from 0 to
            `threading.TIMEOUT_MAX` seconds.
        """
        ...


class SystemClock:
    """The clock of this machine."""

    now_ns = staticmethod(time.time_ns)
    monotonic_ns = staticmethod(time.monotonic_ns)
    sleep = staticmethod(time.sleep)

    def now(self) -> Time:
        """The date, for stamps."""
        return Time.from_nanoseconds(time.time_ns())

    @staticmethod
    def suspended_ns() -> int:
        """Return for how long the machine has slept since it was started; 0 but on Linux."""
        if not hasattr(time, "CLOCK_BOOTTIME"):
            return 0
        return time.clock_gettime_ns(time.CLOCK_BOOTTIME) - time.monotonic_ns()

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """A function that waits for a lock, for so many seconds at most."""
        return partial(wakeup.acquire, True)  # noqa: FBT003 - no names here
