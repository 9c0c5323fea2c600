"""Check the device's clock: compare its dates with the arrival."""

from collections import deque
from itertools import pairwise

__all__ = ["DeviceClock"]

_S = 1_000_000_000
_MINUTE_S, _HOUR_S, _DAY_S = 60.0, 3600.0, 86_400.0
_YEAR_S = 365.25 * _DAY_S

# The least delayed sample of a second tells the clock; a network that stalls for one, not for two.
_WINDOW_NS = _S
_WINDOWS = 2
# A drift is told by the blocks of a minute, if all of them say so. Crystals differ by 0.01 %, and
# what sets a clock gently does so by 0.05 %.
_BLOCK_NS = 10 * _S
_BLOCKS = 7
_DRIFT = 0.005
# The text of a finding stays while the clock is off by about as much, so that it is logged once.
_SAME = 0.5

_ZONES_S = (5.75 * _HOUR_S, 8.75 * _HOUR_S, 12.75 * _HOUR_S, 13.75 * _HOUR_S)
"""Time zones whose offset from UTC is neither whole nor half hours."""
_LARGEST_ZONE_S = 14.0 * _HOUR_S
_ZONE_TOLERANCE_S = 60.0
_GPS_S = 18.0
"""Seconds by which GPS time is ahead of UTC (since 2017)."""
_GPS_ROLLOVER_S = 1024 * 7 * _DAY_S
"""Seconds after which a GPS receiver's week number starts again (modulo 1024)."""


class DeviceClock:
    """Estimates the offset of the device's clock, from the samples with the least delay."""

    def __init__(self, limit_s: float) -> None:
        """Start without an estimate.

        Args:
            limit_s: Seconds by which the clock may be ahead or behind.
        """
        self.limit_ns = round(limit_s * _S)
        self.finding = ""
        """Fault of the clock, in one line; empty if there is none."""
        self._began_ns: int | None = None
        self._ahead_ns = 0
        self._windows_off = 0
        self._blocks: deque[tuple[int, int]] = deque(maxlen=_BLOCKS)
        self._said_ns = 0
        self._said_drift = 0

    def add(self, ahead_ns: int, arrived_ns: int) -> None:
        """Take a sample whose date is ahead of its arrival by `ahead_ns`."""
        if self._began_ns is None:
            self._began_ns, self._ahead_ns = arrived_ns, ahead_ns
        self._ahead_ns = max(self._ahead_ns, ahead_ns)
        if not 0 <= arrived_ns - self._began_ns < _WINDOW_NS:
            self._judge(self._ahead_ns, arrived_ns)
            self._began_ns = None

    def _judge(self, ahead_ns: int, arrived_ns: int) -> None:
        drift = self._drift(ahead_ns, arrived_ns)
        is_off = abs(ahead_ns) > self.limit_ns
        self._windows_off = self._windows_off + 1 if is_off else 0
        if self._windows_off >= _WINDOWS or drift:
            self._say(ahead_ns, drift)
        elif not is_off:
            self.finding = ""

    def _say(self, ahead_ns: int, drift: float) -> None:
        direction = (drift > 0.0) - (drift < 0.0)
        changed_ns = abs(ahead_ns - self._said_ns)
        is_same = changed_ns <= _SAME * max(self.limit_ns, abs(self._said_ns))
        if self.finding and is_same and direction == self._said_drift:
            return
        self._said_ns, self._said_drift = ahead_ns, direction
        self.finding = f"the device's clock {_offset(ahead_ns / _S, self.limit_ns / _S, drift)}"

    def _drift(self, ahead_ns: int, arrived_ns: int) -> float:
        """Return the seconds that the clock gains in each second; 0 if it keeps step."""
        blocks = self._blocks
        if blocks and arrived_ns < blocks[-1][0]:
            blocks.clear()
        if not blocks or arrived_ns - blocks[-1][0] >= _BLOCK_NS:
            blocks.append((arrived_ns, ahead_ns))
        if len(blocks) < _BLOCKS:
            return 0.0
        rates = [
            (later - earlier) / (later_at - at)
            for (at, earlier), (later_at, later) in pairwise(blocks)
        ]
        mean = (blocks[-1][1] - blocks[0][1]) / (blocks[-1][0] - blocks[0][0])
        if abs(mean) < _DRIFT:
            return 0.0
        # A step shows in one block, a drift in all.
        return mean if all(0.5 <= rate / mean <= 2.0 for rate in rates) else 0.0


def _offset(ahead_s: float, limit_s: float, drift: float) -> str:
    gains = f"{'gains' if drift > 0.0 else 'loses'} {abs(drift) * _MINUTE_S:.1f} s a minute"
    if abs(ahead_s) <= limit_s:
        return f"{gains}: does it count in its unit?"
    side = "ahead" if ahead_s > 0.0 else "behind"
    off = f"is {_duration(abs(ahead_s))} {side}"
    return f"{off} and {gains}" if drift else f"{off}: {_cause(ahead_s)}"


def _cause(ahead_s: float) -> str:
    size_s = abs(ahead_s)
    zones = (*_ZONES_S, max(1.0, round(2.0 * size_s / _HOUR_S)) * _HOUR_S / 2.0)
    if size_s <= _LARGEST_ZONE_S + _ZONE_TOLERANCE_S and any(
        abs(size_s - zone_s) <= _ZONE_TOLERANCE_S for zone_s in zones
    ):
        return "a time zone?"
    if abs(ahead_s - _GPS_S) <= 1.0:
        return "GPS time, without its leap seconds?"
    if abs(ahead_s + _GPS_ROLLOVER_S) <= _DAY_S:
        return "a GPS receiver that counts its weeks from another year?"
    return "are both clocks set?"


def _duration(seconds: float) -> str:
    """Return a duration in its largest two units, for people."""
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    units = (
        ("years", _YEAR_S), ("days", _DAY_S), ("h", _HOUR_S), ("min", _MINUTE_S), ("s", 1.0)
    )  # fmt: skip
    left = round(seconds)
    if seconds >= _HOUR_S:
        left = round(seconds / _MINUTE_S) * 60
    parts = []
    for name, size_s in units:
        number, left = divmod(left, int(size_s))
        if number:
            parts.append(f"{number} {name}")
        elif parts:
            break
        if len(parts) == 2:
            break
    return " ".join(parts)
