"""A fixed rate: which tick is due next, and how many were missed. Reads no clock."""

import threading
from fractions import Fraction
from operator import sub

from rosbase.runtime.histogram import Histogram

__all__ = ["LoopStats", "Rate"]

_NS_PER_S = 1_000_000_000
_NS_PER_MS = 1_000_000


class Rate:
    """Absolute deadlines, start + n x period, that never drift.

    A tick that is late runs at once, and the phase is kept. Ticks whose whole period has
    passed are skipped: there is never a burst.
    """

    __slots__ = (
        "_left_over",
        "_parts",
        "_period_ns",
        "_rest",
        "deadline_ns",
        "skipped",
        "whole_period_ns",
    )

    def __init__(self, frequency_hz: float, start_ns: int) -> None:
        """Start at `start_ns` (monotonic); the first deadline is that instant.

        Raises:
            ValueError: The frequency is not a positive, finite number.
        """
        if not _is_rate(frequency_hz):
            raise ValueError(f"a rate is a positive number of hertz, not {frequency_hz!r}")
        # As it is written: 333.3 Hz has a short fraction, what a float makes of it a long one.
        period = _NS_PER_S / Fraction(repr(float(frequency_hz)))
        # Whole nanoseconds, and what is left over, in parts of `_parts`.
        self._period_ns, self._rest = divmod(period.numerator, period.denominator)
        self._parts = period.denominator
        self.whole_period_ns = 0 if self._rest else self._period_ns
        """Period, if it is a whole number of nanoseconds; else 0."""
        self._left_over = 0
        self.deadline_ns = start_ns
        """Time of the next tick, on the monotonic clock."""
        self.skipped = 0
        """Number of ticks skipped because their periods had passed."""

    def advance(self, now_ns: int) -> int:
        """Move on to the first tick whose period has not passed by `now_ns`.

        Returns:
            The time at which it is due.
        """
        self.deadline_ns = deadline_ns = self.deadline_ns + self._period_ns
        if self._rest:
            deadline_ns = self._carry(1)
        if now_ns - deadline_ns >= self._period_ns:
            deadline_ns = self._skip(now_ns)
        return deadline_ns

    def _carry(self, periods: int) -> int:
        carried, self._left_over = divmod(self._left_over + periods * self._rest, self._parts)
        self.deadline_ns += carried
        return self.deadline_ns

    def _skip(self, now_ns: int) -> int:
        period = self._period_ns * self._parts + self._rest
        late = (now_ns - self.deadline_ns) * self._parts - self._left_over
        periods = late // period
        self.skipped += periods
        self.deadline_ns += periods * self._period_ns
        return self._carry(periods)


def _is_rate(value: object) -> bool:
    if isinstance(value, str):
        return False
    try:
        return 0.0 < float(value) < float("inf")  # type: ignore[arg-type]  # or TypeError
    except (TypeError, ValueError, OverflowError):
        return False


class LoopStats:
    """Statistics of a fixed-rate loop, at almost no cost.

    The loop only notes when each tick started and ended. Percentiles are computed from the
    notes when there are many, or when you ask for them, from any thread.
    """

    __slots__ = ("_busy", "_digested", "_last_start_ns", "_lock", "_period", "notes", "overruns")

    MANY_TICKS = 500
    """Number of ticks whose notes are digested together.

    With fewer, each would cost more, because the processor is warm only later. More would take
    a large part of a millisecond.
    """

    def __init__(self) -> None:
        self.overruns = 0
        """Number of ticks skipped because the one before took too long."""
        self.notes: list[int] = []
        """Start, end, start, end, ... of the ticks on the monotonic clock, appended by the loop."""
        self._digested = 0
        self._period = Histogram()
        self._busy = Histogram()
        self._last_start_ns: int | None = None
        self._lock = threading.Lock()

    def __repr__(self) -> str:
        return (
            f"<LoopStats ticks={self.ticks} overruns={self.overruns}"
            f" period_p50_ms={self.period.percentile(50) / _NS_PER_MS:.3f}"
            f" busy_p50_ms={self.busy.percentile(50) / _NS_PER_MS:.3f}>"
        )

    @property
    def ticks(self) -> int:
        """Number of ticks that ran."""
        with self._lock:
            return self._digested + len(self.notes) // 2

    @property
    def tick_started_ns(self) -> int | None:
        """Start of the tick that runs now, on the monotonic clock; None between two ticks."""
        with self._lock:
            # The loop may append meanwhile.
            count = len(self.notes)
            return self.notes[count - 1] if count % 2 else None

    def end_tick(self) -> None:
        """Forget the start of a tick that an exception has ended."""
        with self._lock:
            if len(self.notes) % 2:
                self.notes.pop()

    @property
    def period(self) -> Histogram:
        """Nanoseconds from the start of one tick to the start of the next."""
        self.digest()
        return self._period

    @property
    def busy(self) -> Histogram:
        """Nanoseconds spent in a tick."""
        self.digest()
        return self._busy

    def digest_if_many(self) -> None:
        """Compute percentiles from the notes if there are many."""
        if len(self.notes) >= 2 * self.MANY_TICKS:
            self.digest()

    def digest(self) -> None:
        """Compute percentiles from the notes."""
        with self._lock:
            # A start whose end is yet to come stays, as does what is appended meanwhile.
            notes = self.notes[: len(self.notes) // 2 * 2]
            if not notes:
                return
            starts, ends = notes[::2], notes[1::2]
            self._busy.record_all(list(map(sub, ends, starts)))
            known = starts if self._last_start_ns is None else [self._last_start_ns, *starts]
            self._last_start_ns = starts[-1]
            if len(known) > 1:
                self._period.record_all(list(map(sub, known[1:], known)))
            self._digested += len(notes) // 2
            del self.notes[: len(notes)]
