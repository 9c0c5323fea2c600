"""Does gravity look like gravity? A wrong unit shows at rest, and is said, never mended."""

from rosbase.imu.units import STANDARD_GRAVITY

__all__ = ["Plausibility"]

_WINDOW = 50
# At rest, the norm of the acceleration varies by noise only: cheap sensors have a standard
# deviation below 0.1 m/s^2. Turning the sensor does not change the norm of gravity.
_STILL_RATIO = 0.04
_STILL_STDDEV = 0.15
# Offsets and scale errors of cheap sensors reach some per cent of g.
_TOLERANCE = 0.15


class Plausibility:
    """Watches the acceleration, and judges each window in which the sensor was at rest."""

    __slots__ = ("_count", "_squares", "_sum", "finding")

    def __init__(self) -> None:
        self.finding = ""
        """What is wrong with the acceleration at rest, in one line; empty if nothing."""
        self._count = 0
        self._sum = 0.0
        self._squares = 0.0

    def add(self, acceleration: tuple[float, ...]) -> None:
        """Takes the acceleration of one sample, in m/s^2."""
        x, y, z = acceleration
        squared = x * x + y * y + z * z
        self._squares += squared
        self._sum += squared**0.5
        self._count += 1
        if self._count == _WINDOW:
            self.finding = self._judge()
            self._count, self._sum, self._squares = 0, 0.0, 0.0

    def _judge(self) -> str:
        norm = self._sum / _WINDOW
        variance = max(0.0, self._squares / _WINDOW - norm * norm)
        if variance**0.5 > max(_STILL_RATIO * norm, _STILL_STDDEV):
            # It moves, which says nothing about what was found at rest.
            return self.finding
        return _finding(norm)


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
