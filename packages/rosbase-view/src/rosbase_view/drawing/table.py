"""Columns that share the width of a pane."""

from collections.abc import Sequence

from attrs import frozen

from rosbase_view.drawing.lines import Ink, Line, Span, cells, clipped

__all__ = ["Cell", "Column", "head_line", "row_line", "widths"]

_GAP = "  "


@frozen
class Column:
    """A column of a table."""

    title: str
    least: int
    """Cells that it takes at least."""
    share: int = 0
    """Parts of the room that is left over."""
    is_right: bool = False
    """Whether its cells end at the right."""


@frozen
class Cell:
    """Text of a column."""

    text: str
    ink: Ink = Ink.PLAIN


def widths(columns: Sequence[Column], width: int) -> list[int]:
    """Return the widths of the columns; the last ones have none if there is no room for them."""
    found: list[int] = []
    left = width
    for column in columns:
        need = column.least + (len(_GAP) if found else 0)
        if need > left:
            break
        found.append(column.least)
        left -= need
    shares = sum(column.share for column in columns[: len(found)])
    for number, column in enumerate(columns[: len(found)]):
        if column.share:
            more = left * column.share // shares
            shares -= column.share
            left -= more
            found[number] += more
    return found + [0] * (len(columns) - len(found))


def head_line(columns: Sequence[Column], sizes: Sequence[int], margin: str = "  ") -> Line:
    """Return the titles."""
    return row_line([Cell(c.title, Ink.DIM) for c in columns], columns, sizes, margin)


def row_line(
    row: Sequence[Cell],
    columns: Sequence[Column],
    sizes: Sequence[int],
    margin: str = "  ",
    ink: Ink | None = None,
) -> Line:
    """Return a row.

    Args:
        row: A cell for each column.
        columns: The columns.
        sizes: Their widths, from `widths`.
        margin: Text in front of the row.
        ink: Meaning of the whole row, in place of its cells' own.
    """
    spans = [Span(margin, ink or Ink.PLAIN)]
    for cell, column, width in zip(row, columns, sizes, strict=True):
        if width <= 0:
            break
        text = clipped(cell.text, width)
        padding = " " * (width - cells(text))
        text = padding + text if column.is_right else text + padding
        spans.append(Span(text if len(spans) == 1 else _GAP + text, ink or cell.ink))
    return tuple(spans)
