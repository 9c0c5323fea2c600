"""Bars for numbers."""

from rosbase_view.drawing.glyphs import Glyphs

__all__ = ["Scale", "filled", "signed"]

_STEPS = (1.0, 2.0, 5.0, 10.0)


class Scale:
    """The number at the end of a bar: 1, 2 or 5 times a power of ten, which never shrinks."""

    def __init__(self, least: float) -> None:
        """Start with the smallest scale."""
        self.most = least

    def include(self, *values: float) -> None:
        """Grow until all finite values fit."""
        largest = max((abs(value) for value in values if abs(value) < float("inf")), default=0.0)
        if largest > self.most:
            self.most = _round_up(largest)


def _round_up(value: float) -> float:
    power = 1.0
    while power * 10.0 < value:
        power *= 10.0
    while power >= value:
        power /= 10.0
    return next(step * power for step in _STEPS if step * power >= value)


def signed(value: float, most: float, width: int, glyphs: Glyphs) -> str:
    """Return a bar from the middle to the right, or to the left for a negative number."""
    side = max(0, width - 1) // 2
    share = abs(value) / most if most > 0.0 else 0.0
    # Not a number is no bar.
    length = round(min(1.0, share) * side) if share >= 0.0 else 0
    text = glyphs.block * length
    if value < 0:
        return text.rjust(side) + glyphs.middle + " " * side
    return " " * side + glyphs.middle + text.ljust(side)


def filled(share: float, width: int, glyphs: Glyphs) -> str:
    """Return a bar from the left, for a share from 0 to 1, with half cells."""
    halves = round(max(0.0, min(1.0, share)) * 2 * width)
    full, half = divmod(halves, 2)
    return (glyphs.block * full + glyphs.half * half).ljust(width)[:width]
