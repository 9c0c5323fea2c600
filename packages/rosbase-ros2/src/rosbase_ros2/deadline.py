"""A limit of time that several waits share."""

from rosbase import Clock, SystemClock

__all__ = ["Deadline"]

_NS_PER_S = 1_000_000_000


class Deadline:
    """A time that begins to run out when the object is created."""

    def __init__(self, patience_s: float, clock: Clock | None = None) -> None:
        """Set the deadline.

        Args:
            patience_s: How long it is from now, in seconds.
            clock: The clock that measures it; by default, the machine's.
        """
        self._clock = clock or SystemClock()
        self._ns = self._clock.monotonic_ns() + int(patience_s * _NS_PER_S)

    @property
    def left_s(self) -> float:
        """Time left, in seconds; 0 once it is up."""
        return max(0.0, (self._ns - self._clock.monotonic_ns()) / _NS_PER_S)
