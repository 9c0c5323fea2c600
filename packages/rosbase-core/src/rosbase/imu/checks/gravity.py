"""Check the size of gravity. At rest it shows a wrong unit, which is reported, never corrected."""

from typing import ClassVar

from rosbase.imu.checks.window import Window
from rosbase.imu.units import STANDARD_GRAVITY

__all__ = ["Gravity"]

# Offsets and scale errors of cheap sensors reach some per cent of g.
_TOLERANCE = 0.15
# Motion adds to gravity, so the mean norm of a moving sensor is near g, and not at it.
_MOVING_TOLERANCE = 0.25
_WINDOWS_TO_HEAL = 2
# The text of a finding stays while its number varies by less, so that it is logged once.
_SAME = 0.1


class Gravity:
    """Judges the norm of the acceleration in windows.

    Only rest shows a wrong norm. Motion cannot show one, but it can clear a finding. With a
    wrong unit, or while a sensor boots, many windows in a row are not near g.
    """

    reason: ClassVar[str] = "implausible"

    __slots__ = ("_found", "_moving_near_g", "finding")

    def __init__(self) -> None:
        self.finding = ""
        """Fault of the acceleration at rest, in one line; empty if there is none."""
        self._found = 0.0
        self._moving_near_g = 0

    def judge(self, window: Window) -> None:
        """Compare a window with gravity."""
        norm = window.norm
        if window.is_still:
            self._moving_near_g = 0
            self._find(norm)
        elif self.finding:
            error = abs(norm - STANDARD_GRAVITY)
            is_near_g = error <= _MOVING_TOLERANCE * STANDARD_GRAVITY
            is_nearer = error < abs(norm - self._found)
            self._moving_near_g = self._moving_near_g + 1 if is_near_g and is_nearer else 0
            if self._moving_near_g >= _WINDOWS_TO_HEAL:
                self.finding = ""

    def _find(self, norm: float) -> None:
        said = _finding(norm)
        if said and self.finding and abs(norm - self._found) <= _SAME * max(self._found, 1.0):
            return
        self.finding, self._found = said, norm


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
