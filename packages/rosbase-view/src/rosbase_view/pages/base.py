"""The common part of all pages."""

from collections.abc import Hashable, Sequence
from typing import ClassVar

from rosbase_view.drawing.glyphs import Glyphs
from rosbase_view.drawing.lines import Ink, Line
from rosbase_view.drawing.table import Cell, Column, head_line, row_line, widths
from rosbase_view.known import Known
from rosbase_view.pages.page import Edit, Pane
from rosbase_view.source import Change, Gaze

__all__ = ["BasePage"]


class BasePage:
    """A page that shows a table. Subclasses give the columns and the cells."""

    title: str = ""
    hints: Sequence[tuple[str, str]] = ()
    follows: bool = False
    detail_rows: int = 5
    columns: ClassVar[Sequence[Column]] = ()

    def __init__(self, known: Known, glyphs: Glyphs) -> None:
        """Show what is known, with these characters."""
        self.known = known
        self.glyphs = glyphs
        self._sizes: tuple[int, list[int]] = (-1, [])

    def keys(self) -> Sequence[Hashable]:
        """Return the rows."""
        raise NotImplementedError

    def first_choice(self) -> Hashable | None:
        """Return the first row."""
        return next(iter(self.keys()), None)

    def cells(self, key: Hashable, pane: Pane) -> Sequence[Cell]:
        """Return the cells of a row."""
        raise NotImplementedError

    def head(self, width: int) -> Line:
        """Return the titles of the columns."""
        return head_line(self.columns, self.sizes(width))

    def row(self, key: Hashable, pane: Pane, *, is_chosen: bool) -> Line:
        """Return a row."""
        margin = f"{self.glyphs.chosen} " if is_chosen else "  "
        ink = Ink.CHOSEN if is_chosen else None
        return row_line(self.cells(key, pane), self.columns, self.sizes(pane.width), margin, ink)

    def detail(self, key: Hashable | None, pane: Pane, first: int) -> list[Line]:
        """Return nothing: the row tells all."""
        return []

    def gaze(self, key: Hashable | None) -> Gaze:
        """Return that nothing more is needed."""
        return Gaze()

    def press(self, key: str, chosen: Hashable | None) -> Change | Edit | int | None:
        """Take no keys."""
        return None

    def sizes(self, width: int) -> list[int]:
        """Return the widths of the columns of a pane, behind the margin."""
        if self._sizes[0] != width:
            self._sizes = (width, widths(self.columns, width - 2))
        return self._sizes[1]
