"""A row of bars for the last values."""

from collections import deque

from rosbase_view.drawing.glyphs import Glyphs

__all__ = ["Sparkline"]


class Sparkline:
    """Keeps the last values, none of them negative, and draws them; the largest fills its cell."""

    def __init__(self, most: int = 64) -> None:
        """Keep at most so many values."""
        self._values: deque[float] = deque(maxlen=most)

    def add(self, value: float) -> None:
        """Take one more value."""
        self._values.append(value)

    def draw(self, width: int, glyphs: Glyphs) -> str:
        """Return the last values as `width` cells, the newest one at the right."""
        shown = list(self._values)[-width:] if width > 0 else []
        most = max(shown, default=0.0)
        if most <= 0.0:
            return ("".join(glyphs.levels[0] for _ in shown)).rjust(max(0, width))
        top = len(glyphs.levels) - 1
        # A value that is not 0 is never drawn as none.
        levels = (0 if v <= 0.0 else max(1, round(v / most * top)) for v in shown)
        return "".join(glyphs.levels[level] for level in levels).rjust(width)
