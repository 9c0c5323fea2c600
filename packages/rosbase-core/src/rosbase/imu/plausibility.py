"""Does gravity look like gravity? A wrong unit shows at rest, and is said, never mended."""

from rosbase.imu.units import STANDARD_GRAVITY

__all__ = ["Plausibility"]

_WINDOW = 50
# At rest, the squared norm of the acceleration stays within 2 % over the window (noise of
# cheap sensors is well below), and each angular rate within 0.05 in whatever unit it is.
_STILL_RATIO = 0.02
_STILL_RATE = 0.05
# Offsets and scale errors of cheap sensors reach some per cent of g.
_TOLERANCE = 0.15


class Plausibility:
    """Watches samples, and judges each window in which the sensor was at rest."""

    __slots__ = ("_count", "_max", "_min", "_rate_max", "_rate_min", "_sum", "finding")

    def __init__(self) -> None:
        self.finding = ""
        """What is wrong with the acceleration at rest, in one line; empty if nothing."""
        self._count = 0
        self._sum = 0.0
        self._min = self._rate_min = float("inf")
        self._max = self._rate_max = float("-inf")

    def add(
        self, acceleration: tuple[float, ...], angular_velocity: tuple[float, ...] | None
    ) -> None:
        """Takes one sample: m/s^2 and rad/s."""
        x, y, z = acceleration
        squared = x * x + y * y + z * z
        self._sum += squared
        self._min = min(self._min, squared)
        self._max = max(self._max, squared)
        if angular_velocity is not None:
            rate = sum(angular_velocity)
            self._rate_min = min(self._rate_min, rate)
            self._rate_max = max(self._rate_max, rate)
        self._count += 1
        if self._count == _WINDOW:
            self.finding = self._judge()
            self._count, self._sum = 0, 0.0
            self._min = self._rate_min = float("inf")
            self._max = self._rate_max = float("-inf")

    def _judge(self) -> str:
        mean = self._sum / _WINDOW
        # Without gravity there is only noise left, whose ratio says nothing.
        still = self._max - self._min <= max(_STILL_RATIO * mean, 0.01)
        if not still or self._rate_max - self._rate_min > _STILL_RATE:
            return self.finding
        return _finding(mean**0.5)


def _finding(norm: float) -> str:
    if abs(norm - STANDARD_GRAVITY) <= _TOLERANCE * STANDARD_GRAVITY:
        return ""
    said = f"at rest the acceleration is {norm:.3g} m/s^2 instead of {STANDARD_GRAVITY:.4g}"
    if abs(norm - 1.0) <= _TOLERANCE:
        return f"{said}: are the numbers in g?"
    if abs(norm - 1000.0) <= _TOLERANCE * 1000.0:
        return f"{said}: are the numbers in mg?"
    if norm < 1.0:
        return f"{said}: the device has taken gravity out, which imu/data must contain"
    return f"{said}: is the unit right?"
