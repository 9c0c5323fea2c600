"""Clock that stands still until a thread waits on it or advances it."""

import threading
from collections.abc import Callable

from rosbase.messages import Time

__all__ = ["ManualClock"]

_NS_PER_S = 1_000_000_000
_FOR_EVER = 5_000_000


class ManualClock:
    """Virtual clock: a wait takes no real time unless another thread ends it.

    A wait on this clock moves the clock to the end of the wait and returns at once. So a manager
    with its timers and its handlers runs as fast as the machine can, and the same way each time.

    If nothing waits, such as two nodes that answer each other's every message, time stands still.
    After some millions of readings, the clock raises a RuntimeError. Call
    `advance` in one of the callbacks, as if the callback took that time.

    If a run takes longer than `real_limit_s`, it ends with a TimeoutError that says where it hangs.
    """

    def __init__(
        self, now_ns: int = 1_700_000_000_000_000_000, *, real_limit_s: float | None = 6.0
    ) -> None:
        """Start the clock.

        Args:
            now_ns: The date in nanoseconds since the Unix epoch.
            real_limit_s: How long a run on this clock may take in real time, in seconds; None for
                no limit.
        """
        self.real_limit_s = real_limit_s
        """Limit of a run in real time, in seconds."""
        self.date_ns = now_ns
        """Date at which the clock was started. Set it to step the date, as NTP may."""
        self.elapsed_ns = 0
        """Time since the clock was started."""
        self.asleep_ns = 0
        """Time for which the machine has slept; see `suspend`."""
        self._last_ns = 0
        self._looks = 0

    def now(self) -> Time:
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(self.now_ns())

    def now_ns(self) -> int:
        """Return the date in nanoseconds since the Unix epoch."""
        return self.date_ns + self.elapsed_ns + self.asleep_ns

    def suspended_ns(self) -> int:
        """Return the time for which the machine has slept."""
        return self.asleep_ns

    def monotonic_ns(self) -> int:
        """Return the nanoseconds since the clock was started.

        Raises:
            RuntimeError: Millions of readings, and time stands still.
        """
        now_ns = self.elapsed_ns
        if now_ns != self._last_ns:
            self._last_ns, self._looks = now_ns, 0
        self._looks += 1
        if self._looks > _FOR_EVER:
            self._looks = 0
            raise RuntimeError(
                "virtual time stands still: do two callbacks keep calling each other?"
            )
        return now_ns

    def advance(self, seconds: float) -> None:
        """Advance the clock. In a callback, this is the time that the callback takes.

        Raises:
            ValueError: The duration is negative.
        """
        if seconds < 0:
            raise ValueError(f"time cannot be turned back by {-seconds:g} s")
        self.elapsed_ns += round(seconds * _NS_PER_S)

    def suspend(self, seconds: float) -> None:
        """Suspend the machine, as a laptop: only the date moves on."""
        self.asleep_ns += round(seconds * _NS_PER_S)

    def sleep(self, seconds: float) -> None:
        """Advance the clock by that duration."""
        self.advance(seconds)

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """Return a function that advances by some seconds, unless the lock can be taken."""

        def wait(timeout_s: float) -> bool:
            if wakeup.acquire(blocking=False):
                return True
            self.advance(timeout_s)
            return False

        return wait
