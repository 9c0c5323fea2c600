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
        self._columns, self._rows = max(0, columns), max(0, rows)
        self._has_dots = glyphs.has_dots
        self._across, self._down = (2, 4) if glyphs.has_dots else (1, 1)
        self.width, self.height = self._columns * self._across, self._rows * self._down
        """Dots across and down."""
        self.aspect = 1.0 if glyphs.has_dots else 2.0
        """Height of a dot, with its width as the unit: a cell is twice as high as wide."""
        # Dots of each cell that has any, as bits; most cells have none.
        self._cells: dict[tuple[int, int], int] = {}

    def line(self, begin: tuple[float, float], end: tuple[float, float]) -> None:
        """Draw from one point to another, both in dots from the upper left corner."""
        (x, y), (to_x, to_y) = begin, end
        steps = max(1, round(max(abs(to_x - x), abs(to_y - y))))
        step_x, step_y = (to_x - x) / steps, (to_y - y) / steps
        for step in range(steps + 1):
            self._set(round(x + step_x * step), round(y + step_y * step))

    def text(self) -> list[str]:
        """Return the picture as one text for each row of cells."""
        rows = [[" "] * self._columns for _ in range(self._rows)]
        for (column, row), bits in self._cells.items():
            rows[row][column] = chr(_BRAILLE + bits) if self._has_dots else "*"
        return ["".join(row) for row in rows]

    def _set(self, x: int, y: int) -> None:
        if 0 <= x < self.width and 0 <= y < self.height:
            column, dot_x = divmod(x, self._across)
            row, dot_y = divmod(y, self._down)
            cell = column, row
            self._cells[cell] = self._cells.get(cell, 0) | _BITS[dot_y][dot_x]
