"""Join the reports of the last seconds into one. Pure."""

from __future__ import annotations

import math
from collections import deque

TYPE_CHECKING = False
if TYPE_CHECKING:
    from rosbase.control.shapes import Window

__all__ = ["Pool"]

# Prefixes of the keys of a measure, and the end of its unit.
_KEYS = {"interval": ("", "_ns"), "bytes": ("bytes_", ""), "delay": ("delay_", "_ns")}


class Pool:
    """Mean, spread and limits of the newest messages, from reports on some of them each."""

    def __init__(self, most: int, measure: str) -> None:
        """Join reports on about `most` messages: the oldest are left out whole."""
        self._most = most
        self._prefix, self._end = _KEYS[measure]
        # Number, mean, standard deviation, least, most and seconds of each report.
        self._parts: deque[tuple[int, float, float, float, float, float]] = deque()

    def add(self, window: Window) -> bool:
        """Take a report; return whether there was anything in it."""
        number = window.get(f"{self._prefix}count", window.get("count", 0))
        if not isinstance(number, int) or number == 0:
            return False
        mean, std, least, most = (
            float(window.get(f"{self._prefix}{name}{self._end}", 0) or 0)  # type: ignore[arg-type]  # a number
            for name in ("mean", "std", "min", "max")
        )
        self._parts.append((number, mean, std, least, most, window.get("seconds", 0.0)))
        while len(self._parts) > 1 and self.count - self._parts[0][0] >= self._most:
            self._parts.popleft()
        return True

    @property
    def count(self) -> int:
        """Number of messages."""
        return sum(part[0] for part in self._parts)

    @property
    def mean(self) -> float:
        """Mean of all of them."""
        return sum(part[0] * part[1] for part in self._parts) / self.count

    @property
    def std(self) -> float:
        """Standard deviation of all of them."""
        mean = self.mean
        squares = sum(n * (std**2 + (m - mean) ** 2) for n, m, std, *_ in self._parts)
        return math.sqrt(squares / self.count)

    @property
    def least(self) -> float:
        """Smallest value."""
        return min(part[3] for part in self._parts)

    @property
    def most(self) -> float:
        """Largest value."""
        return max(part[4] for part in self._parts)

    @property
    def seconds(self) -> float:
        """Time in which they were published."""
        return sum(part[5] for part in self._parts)
