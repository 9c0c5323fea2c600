"""A fixed rate: which tick is due next, and how many were missed. Reads no clock."""

from rosbase.histogram import Histogram

__all__ = ["LoopStats", "Rate"]

_NS_PER_S = 1_000_000_000


class Rate:
    """Absolute deadlines, start + n x period, that nothing can make drift.

    A tick that is late runs at once, and the phase is kept. Ticks whose whole period has
    passed are skipped: there is never a burst.
    """

    __slots__ = ("_frequency_hz", "_index", "_start_ns")

    def __init__(self, frequency_hz: float, start_ns: int) -> None:
        """Starts at `start_ns` (monotonic); the first deadline is that instant.

        Raises:
            ValueError: The frequency is not a positive, finite number.
        """
        if not 0.0 < frequency_hz < float("inf"):
            raise ValueError(f"a rate is a positive number of hertz, not {frequency_hz!r}")
        self._frequency_hz = frequency_hz
        self._start_ns = start_ns
        self._index = 0

    @property
    def deadline_ns(self) -> int:
        """When the next tick is due, on the monotonic clock."""
        return self._start_ns + int(self._index * _NS_PER_S / self._frequency_hz)

    def advance(self, now_ns: int) -> int:
        """Moves on to the next tick.

        Returns:
            How many ticks were skipped, because their periods had passed by `now_ns`.
        """
        due = int((now_ns - self._start_ns) * self._frequency_hz / _NS_PER_S)
        skipped = max(0, due - self._index - 1)
        self._index += 1 + skipped
        return skipped


class LoopStats:
    """What a fixed-rate loop did, at next to no cost."""

    __slots__ = ("_last_start_ns", "busy", "overruns", "period", "ticks")

    def __init__(self) -> None:
        self.ticks = 0
        """Ticks that ran."""
        self.overruns = 0
        """Ticks that were skipped because the one before took too long."""
        self.period = Histogram()
        """Nanoseconds from the start of one tick to the start of the next."""
        self.busy = Histogram()
        """Nanoseconds spent in a tick."""
        self._last_start_ns: int | None = None

    def record(self, start_ns: int, end_ns: int, skipped: int) -> None:
        """Counts one tick, by its start and end on the monotonic clock."""
        if self._last_start_ns is not None:
            self.period.record(start_ns - self._last_start_ns)
        self._last_start_ns = start_ns
        self.busy.record(end_ns - start_ns)
        self.ticks += 1
        self.overruns += skipped
