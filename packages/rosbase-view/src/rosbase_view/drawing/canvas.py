"""Straight lines, drawn with the dots of the cells of a terminal."""

from rosbase_view.drawing.glyphs import Glyphs

__all__ = ["Canvas"]

_BRAILLE = 0x2800
# Bits of the dots of a cell by row and column, as Unicode numbers them.
_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))


class Canvas:
    """A picture of some columns and rows."""

    def __init__(self, columns: int, rows: int, glyphs: Glyphs) -> None:
        """Begin with an empty picture."""
        self._columns, self._rows = columns, rows
        self._has_dots = glyphs.has_dots
        across, down = (2, 4) if glyphs.has_dots else (1, 1)
        self.width, self.height = columns * across, rows * down
        """Dots across and down."""
        self.aspect = 1.0 if glyphs.has_dots else 2.0
        """Height of a dot, with its width as the unit: a cell is twice as high as wide."""
        self._dots: set[tuple[int, int]] = set()
        self._marks: dict[tuple[int, int], str] = {}

    def line(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        """Draw from one point to another, both in dots from the upper left corner."""
        (x, y), (to_x, to_y) = begin, end
        steps = max(1, round(max(abs(to_x - x), abs(to_y - y))))
        for step in range(steps + 1):
            share = step / steps
            self._set(round(x + (to_x - x) * share), round(y + (to_y - y) * share))

    def mark(self, at: tuple[float, float], character: str) -> None:
        """Put a character into the cell of a point, over whatever is drawn there."""
        across, down = (2, 4) if self._has_dots else (1, 1)
        self._marks[round(at[0]) // across, round(at[1]) // down] = character

    def text(self) -> list[str]:
        """Return the picture as one text for each row of cells."""
        return [
            "".join(self._cell(column, row) for column in range(self._columns))
            for row in range(self._rows)
        ]

    def _set(self, x: int, y: int) -> None:
        if 0 <= x < self.width and 0 <= y < self.height:
            self._dots.add((x, y))

    def _cell(self, column: int, row: int) -> str:
        if (column, row) in self._marks:
            return self._marks[column, row]
        if not self._has_dots:
            return "*" if (column, row) in self._dots else " "
        bits = sum(
            bit
            for y, pair in enumerate(_BITS)
            for x, bit in enumerate(pair)
            if (column * 2 + x, row * 4 + y) in self._dots
        )
        return chr(_BRAILLE + bits) if bits else " "
