"""How long a client waits. Reads the time itself, because `rosbase.clock` needs messages."""

import time

__all__ = ["TimeLimit", "pause"]


class TimeLimit:
    """A time from now on, in which something must be done."""

    def __init__(self, seconds: float | None) -> None:
        """Start now; None is without a limit."""
        self._end_ns = None if seconds is None else time.monotonic_ns() + int(seconds * 1e9)

    def restart(self, seconds: float, *, behind_s: float = 0.0) -> None:
        """Have it end this much later, or from now on if that is over already.

        Args:
            seconds: How much later.
            behind_s: How long it may be over already, to catch up with a rate.
        """
        now_ns = time.monotonic_ns()
        end_ns = now_ns if self._end_ns is None else self._end_ns
        self._end_ns = max(end_ns + int(seconds * 1e9), now_ns - int(behind_s * 1e9))

    @property
    def left_s(self) -> float | None:
        """Seconds that are left, 0 or more; None without a limit."""
        if self._end_ns is None:
            return None
        return max(0.0, (self._end_ns - time.monotonic_ns()) / 1e9)

    @property
    def left_ms(self) -> int | None:
        """Whole milliseconds that are left, rounded up, for `select.poll`."""
        left = self.left_s
        return None if left is None else int(left * 1e3 + 0.999)

    @property
    def is_over(self) -> bool:
        """Whether no time is left."""
        return self.left_s == 0.0


def pause(seconds: float) -> None:
    """Do nothing for some time; Ctrl-C ends it."""
    time.sleep(seconds)
