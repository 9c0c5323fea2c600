"""Clocks: the only code that reads time. All other code gets a clock, which tests can control."""

import threading
import time
from collections.abc import Callable
from datetime import datetime, timedelta, timezone
from functools import partial
from typing import Protocol

from rosbase.messages import Time, is_stamp

__all__ = ["Clock", "SystemClock", "date_fault"]

_EPOCH = datetime(1970, 1, 1, tzinfo=timezone.utc)


class Clock(Protocol):
    """A clock: tells the date and a monotonic time, and waits."""

    def now(self) -> Time:
        """Return the date as a stamp; zero if ROS cannot carry it (`rosbase.messages.is_stamp`).

        The date may be set, so it may jump.
        """
        ...

    def now_ns(self) -> int:
        """Return the date in nanoseconds since the Unix epoch."""
        ...

    def monotonic_ns(self) -> int:
        """Return nanoseconds from an arbitrary start, which never go back.

        Use it for intervals and deadlines.
        """
        ...

    def suspended_ns(self) -> int:
        """Return for how long the machine has slept, which `monotonic_ns` leaves out."""
        ...

    def sleep(self, seconds: float, /) -> None:
        """Block for `seconds`, whatever other threads do."""
        ...

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """Return a function that waits for a lock, for a limited number of seconds of this clock.

        Ask for it once before a loop, so that each tick only pays for the wait.

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
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(time.time_ns())

    @staticmethod
    def suspended_ns() -> int:
        """Return for how long the machine has slept since its start; always 0 except on Linux."""
        if not hasattr(time, "CLOCK_BOOTTIME"):
            return 0
        return time.clock_gettime_ns(time.CLOCK_BOOTTIME) - time.monotonic_ns()

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """Return a function that waits for a lock, for a limited number of seconds."""
        return partial(wakeup.acquire, True)  # noqa: FBT003 - no names here


def date_fault(now_ns: int) -> str:
    """Return why a date cannot be a ROS stamp, in one line; empty if it can.

    Args:
        now_ns: The date of this machine, in nanoseconds since the Unix epoch. A simulated clock
            says zero until the first time arrives.
    """
    if is_stamp(now_ns):
        return ""
    if now_ns == 0:
        return "the clock has no date yet; with use_sim_time, does anything publish /clock?"
    try:
        date = f"{_EPOCH + timedelta(microseconds=now_ns // 1000):%Y-%m-%d %H:%M:%S} UTC"
    except OverflowError:
        # Beyond the year 9999, or before the year 1.
        date = f"{now_ns / 1e9:.3g} s after 1970"
    return f"the date of this machine is {date}, and ROS stamps go from 1970 to 2038-01-19"
