"""The last seconds of a quantity, as the columns of a plot. Pure and bounded."""

from collections import deque
from collections.abc import Sequence

__all__ = ["SPAN_S", "Trace"]

SPAN_S = 20.0
"""Seconds that a plot shows."""

_NS = 1e9
# A source passes on 20 messages a second, and sometimes two at once.
_MOST = 1_000
_LONGEST_GAP_S = SPAN_S / 4


class Trace:
    """Samples with their stamps, oldest first."""

    def __init__(self) -> None:
        """Begin empty."""
        self.revision = 0
        """Grows with each sample."""
        self._samples: deque[tuple[int, tuple[float, ...]]] = deque(maxlen=_MOST)

    def add(self, stamp_ns: int, values: tuple[float, ...]) -> None:
        """Take a sample.

        After a time that goes back, as when a recording is rewound, and after a long gap, the
        trace starts anew: a line from there to here would show what was never measured.
        """
        if self._samples:
            passed_s = (stamp_ns - self._samples[-1][0]) / _NS
            if passed_s == 0.0:
                return
            if not 0.0 < passed_s < _LONGEST_GAP_S or len(values) != len(self._samples[-1][1]):
                self._samples.clear()
        self._samples.append((stamp_ns, values))
        while (stamp_ns - self._samples[0][0]) / _NS > SPAN_S:
            self._samples.popleft()
        self.revision += 1

    def columns(self) -> list[Sequence[float]]:
        """Return the seconds before the newest sample, at most 0, and a column for each value."""
        if not self._samples:
            return []
        last_ns = self._samples[-1][0]
        seconds = [(stamp_ns - last_ns) / _NS for stamp_ns, _ in self._samples]
        return [seconds, *zip(*(values for _, values in self._samples), strict=True)]
