"""Bars for signed numbers: they grow from the middle to the right or to the left."""

from rosbase.cli.panel.style import Style

__all__ = ["Scale", "bar"]

_STEPS = (1.0, 2.0, 5.0, 10.0)


class Scale:
    """The number at the end of a bar: it grows to 1, 2 or 5 times a power of ten."""

    def __init__(self, least: float) -> None:
        """Start with the smallest scale."""
        self.most = least
        """Number at the end of the bar."""

    def include(self, *values: float) -> None:
        """Grow until all the values fit."""
        largest = max(map(abs, values))
        if not largest <= self.most < float("inf"):
            self.most = _round_up(largest)

    def __str__(self) -> str:
        return f"{self.most:g}"


def _round_up(value: float) -> float:
    power = 1.0
    while power * 10.0 < value:
        power *= 10.0
    while power >= value:
        power /= 10.0
    return next(step * power for step in _STEPS if step * power >= value)


def bar(value: float, most: float, width: int, style: Style) -> str:
    """Return the bar with an odd number of characters.

    If the terminal supports it, the bar may end with a half character.
    """
    side = width // 2
    halves = min(2 * side, round(abs(value) / most * 2 * side))
    full, half = divmod(halves, 2)
    block = style.words("█", "#")
    middle = style.words("│", "|")
    if value < 0:
        left = (style.words("▐", "#") * half + block * full).rjust(side)
        return left + middle + " " * side
    return " " * side + middle + (block * full + style.words("▌", "#") * half).ljust(side)
