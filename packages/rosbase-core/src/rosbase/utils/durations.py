"""The durations of one kind within one interval, for a line of a report."""

import math
from collections.abc import Sequence

from rosbase.runtime.histogram import Histogram

__all__ = ["Durations"]

_NS_PER_MS = 1e6


class Durations:
    """Durations since the last report: mean, percentiles and maximum."""

    def __init__(self, name: str, threshold_ms: float = math.inf) -> None:
        """Start with none.

        Args:
            name: Their name in the report.
            threshold_ms: Limit beyond which durations are counted; none by default.
        """
        self.name = name
        self.threshold_ns = threshold_ms * _NS_PER_MS
        self.clear()

    def clear(self) -> None:
        """Forget all durations, after a report."""
        self._histogram = Histogram()
        self._total_ns = self._over = 0

    def add(self, durations_ns: Sequence[int]) -> None:
        """Add durations in nanoseconds."""
        self._histogram.record_all(durations_ns)
        self._total_ns += sum(durations_ns)
        if self._histogram.maximum > self.threshold_ns:
            self._over += sum(duration_ns > self.threshold_ns for duration_ns in durations_ns)

    def report(self) -> str:
        """Return the durations in milliseconds; empty if there are none."""
        found = self._histogram
        if not found.count:
            return ""
        mean, most = self._total_ns / found.count / _NS_PER_MS, found.maximum / _NS_PER_MS
        half, late = (found.percentile(percent) / _NS_PER_MS for percent in (50, 99))
        over = f", {self._over} over {self.threshold_ns / _NS_PER_MS:g}" if self._over else ""
        return f"{self.name} {mean:.3f} ms (p50 {half:.3f}, p99 {late:.3f}, max {most:.3f}{over})"
