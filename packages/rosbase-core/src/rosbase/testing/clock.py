"""A clock that stands still until somebody waits or turns it."""

import threading
from collections.abc import Callable

from rosbase.messages import Time

__all__ = ["ManualClock"]

_NS_PER_S = 1_000_000_000
_FOR_EVER = 5_000_000


class ManualClock:
    """Virtual time: a wait that nobody ends takes none of the real one.

    What waits on this clock finds itself at the end of the wait at once. So a manager with its
    timers and its handlers runs as fast as the machine can, and the same way each time.

    Where something never waits, such as two nodes that answer each other's every message, time
    never goes on. After some millions of looks at the clock that is a RuntimeError; call
    `advance` in one of the callbacks, as if it took its time.

    A run that takes longer than `real_limit_s` is a TimeoutError that says where it hangs.
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
        """How long a run may take in real time, in seconds."""
        self.date_ns = now_ns
        """The date at which the clock was started. Set it to step the date, as NTP may."""
        self.elapsed_ns = 0
        """How long it has been running."""
        self.asleep_ns = 0
        """For how long the machine has slept; see `suspend`."""
        self._last_ns = 0
        self._looks = 0

    def now(self) -> Time:
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(self.now_ns())

    def now_ns(self) -> int:
        """The date in nanoseconds since the Unix epoch."""
        return self.date_ns + self.elapsed_ns + self.asleep_ns

    def suspended_ns(self) -> int:
        """Return for how long the machine has slept."""
        return self.asleep_ns

    def monotonic_ns(self) -> int:
        """Nanoseconds since the clock was started.

        Raises:
            RuntimeError: It has been asked for ever without going on.
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
        """Turns the clock. In a callback, that is how long the callback takes.

        Raises:
            ValueError: Time does not go back.
        """
        if seconds < 0:
            raise ValueError(f"time cannot be turned back by {-seconds:g} s")
        self.elapsed_ns += round(seconds * _NS_PER_S)

    def suspend(self, seconds: float) -> None:
        """Have the machine sleep, as a laptop does: only the date goes on."""
        self.asleep_ns += round(seconds * _NS_PER_S)

    def sleep(self, seconds: float) -> None:
        """Moves on by that long."""
        self.advance(seconds)

    def waiter(self, wakeup: threading.Lock) -> Callable[[float], bool]:
        """A function that moves on by so many seconds, unless the lock can be taken."""

        def wait(timeout_s: float) -> bool:
            if wakeup.acquire(blocking=False):
                return True
            self.advance(timeout_s)
            return False

        return wait
