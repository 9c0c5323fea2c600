"""Which signals are one wish: tools and terminals send the same wish twice."""

__all__ = ["Wishes"]

SAME_WISH_NS = 1_000_000_000
"""A signal this soon after the last counted one is the same wish."""


class Wishes:
    """Counts wishes to stop. Pure: the caller says when each signal came."""

    __slots__ = ("_last_ns", "count")

    def __init__(self) -> None:
        self.count = 0
        """How many wishes there have been."""
        self._last_ns = 0

    def add(self, now_ns: int) -> bool:
        """Take a signal; tell whether it is a wish of its own.

        `uv run`, `npm` and terminals signal a whole group and then pass the signal on, so a
        program may get each signal twice.

        Args:
            now_ns: When the signal came, on the monotonic clock.
        """
        if self.count and now_ns - self._last_ns < SAME_WISH_NS:
            return False
        self.count += 1
        self._last_ns = now_ns
        return True
