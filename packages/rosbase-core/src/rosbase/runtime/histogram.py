"""Percentiles of any number of durations in a few kilobytes."""

from collections.abc import Sequence

__all__ = ["Histogram"]

# 32 steps to each doubling: a percentile is at most 1/32 off.
_STEP_BITS = 5
_STEPS = 1 << _STEP_BITS


class Histogram:
    """Counts of non-negative integers in buckets that grow with the value.

    Recording costs one list update, so it is cheap enough for every sample. One thread
    records; others may read meanwhile.
    """

    __slots__ = ("_counts", "count", "maximum")

    def __init__(self) -> None:
        self._counts = [0] * (_STEPS * 60)
        self.count = 0
        """Number of recorded values."""
        self.maximum = 0
        """Largest recorded value; 0 if there is none."""

    def __repr__(self) -> str:
        half, most = self.percentile(50), self.percentile(99)
        return f"<Histogram count={self.count} p50={half} p99={most} maximum={self.maximum}>"

    def record(self, value: int) -> None:
        """Count one value; a negative one counts as 0."""
        self.record_all((value,))

    def record_all(self, values: Sequence[int]) -> None:
        """Count several values, at about half the cost of one by one."""
        counts = self._counts
        last = len(counts) - 1
        for value in values:
            if value < _STEPS:
                index = value if value > 0 else 0
            else:
                shift = value.bit_length() - _STEP_BITS - 1
                # The leading bit and the five below it: (value >> shift) is 32 to 63.
                index = (shift << _STEP_BITS) + (value >> shift)
            counts[index if index < last else last] += 1
        self.count += len(values)
        self.maximum = max(self.maximum, max(values, default=0))

    def percentile(self, percent: float) -> int:
        """Return the value that `percent` of the recorded ones do not exceed.

        It is exact to within 1/32, and 0 if there are none.
        """
        if not self.count:
            return 0
        wanted = percent / 100.0 * self.count
        seen = 0
        for index, number in enumerate(self._counts):
            seen += number
            if number and seen >= wanted:
                return min(_upper_edge(index), self.maximum)
        return self.maximum

    def buckets(self) -> list[tuple[int, int]]:
        """Return the largest value and the count of each bucket that is not empty, in order."""
        return [(_upper_edge(index), number) for index, number in enumerate(self._counts) if number]

    def minimum(self) -> int:
        """Return the smallest recorded value, to within 1/32; 0 if there is none."""
        first = next((index for index, number in enumerate(self._counts) if number), 0)
        return _upper_edge(first - 1) + 1 if first else 0


def _upper_edge(index: int) -> int:
    if index < 2 * _STEPS:
        return index
    shift = (index >> _STEP_BITS) - 1
    return ((_STEPS + (index & (_STEPS - 1)) + 1) << shift) - 1
