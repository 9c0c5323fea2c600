"""The durations of one kind within one interval, for a line of a report."""

from rosbase.runtime.histogram import Histogram

__all__ = ["Durations"]

# Digested so many at a time, because that costs half as much as one by one.
_MANY = 250
_NS_PER_MS = 1e6


class Durations:
    """Durations since the last report: mean, percentiles and maximum."""

    def __init__(self, name: str, threshold_ms: float | None = None) -> None:
        """Start with none.

        Args:
            name: Their name in the report.
            threshold_ms: The limit beyond which durations are counted; none by default.
        """
        self.name = name
        self.threshold_ms = threshold_ms
        self._threshold_ns = None if threshold_ms is None else threshold_ms * _NS_PER_MS
        self.clear()

    def clear(self) -> None:
        """Forget all durations, after a report."""
        self._histogram = Histogram()
        self._new: list[int] = []
        self._total_ns = 0
        self.over = 0
        """Number of durations beyond the threshold."""

    def add(self, duration_ns: int) -> bool:
        """Add a duration; return whether it is the first one beyond the threshold."""
        self._new.append(duration_ns)
        if len(self._new) >= _MANY:
            self._digest()
        if self._threshold_ns is None or duration_ns <= self._threshold_ns:
            return False
        self.over += 1
        return self.over == 1

    def report(self) -> str:
        """Return the durations in milliseconds; empty if there are none."""
        self._digest()
        found = self._histogram
        if not found.count:
            return ""
        mean, most = self._total_ns / found.count / _NS_PER_MS, found.maximum / _NS_PER_MS
        half, late = (found.percentile(percent) / _NS_PER_MS for percent in (50, 99))
        over = f", {self.over} over {self.threshold_ms:g}" if self.over else ""
        return f"{self.name} {mean:.3f} ms (p50 {half:.3f}, p99 {late:.3f}, max {most:.3f}{over})"

    def _digest(self) -> None:
        self._histogram.record_all(self._new)
        self._total_ns += sum(self._new)
        self._new.clear()
