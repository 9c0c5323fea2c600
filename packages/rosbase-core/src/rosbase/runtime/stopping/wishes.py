"""Count signals as requests to stop: tools and terminals send the same request twice."""

__all__ = ["Wishes"]

SAME_WISH_NS = 1_000_000_000
"""Nanoseconds after a counted signal in which another one is the same request."""


class Wishes:
    """Counts requests to stop. Pure: the caller gives the time of each signal."""

    __slots__ = ("_last_ns", "count")

    def __init__(self) -> None:
        self.count = 0
        """Number of requests so far."""
        self._last_ns = 0

    def add(self, now_ns: int) -> bool:
        """Take a signal; return whether it is a new request.

        `uv run`, `npm` and terminals signal a whole group and then pass the signal on, so a
        program may get each signal twice.

        Args:
            now_ns: Time of the signal, on the monotonic clock.
        """
        if self.count and now_ns - self._last_ns < SAME_WISH_NS:
            return False
        self.count += 1
        self._last_ns = now_ns
        return True
