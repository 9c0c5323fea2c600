"""Lines of text with a meaning, which a terminal library gives a colour."""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple, TypeAlias
from unicodedata import combining, east_asian_width

from rosbase import printable

__all__ = ["Ink", "Line", "Span", "blank", "cells", "clipped", "fitted", "joined", "line", "plain"]

_CUT = "~"


class Ink(Enum):
    """Meaning of a text. Nothing is told by it alone, because terminals may have no colour."""

    PLAIN = "plain"
    DIM = "dim"
    TITLE = "title"
    GOOD = "good"
    WARNING = "warning"
    BAD = "bad"
    CHOSEN = "chosen"
    DRAWING = "drawing"
    X = "x"
    Y = "y"
    Z = "z"


class Span(NamedTuple):
    """Text of one meaning."""

    text: str
    ink: Ink = Ink.PLAIN


Line: TypeAlias = tuple[Span, ...]


def line(*parts: Span | str) -> Line:
    """Return a line of these parts; empty ones are left out."""
    spans = (Span(part) if isinstance(part, str) else part for part in parts)
    return tuple(span for span in spans if span.text)


def plain(of: Line) -> str:
    """Return the text of a line."""
    return "".join(span.text for span in of)


def blank(width: int) -> Line:
    """Return an empty line."""
    return (Span(" " * width),) if width > 0 else ()


def cells(text: str) -> int:
    """Return how many cells a text takes."""
    if text.isascii():
        return len(text)
    return sum(_cells_of(character) for character in text)


def clipped(text: str, width: int) -> str:
    """Return text from outside as one line of at most `width` cells; `~` ends one that was cut."""
    safe = printable(text, max(width, 1) + 1) if not text.isprintable() else text
    if cells(safe) <= width:
        return safe
    return _first_cells(safe, width - 1) + _CUT if width > 0 else ""


def fitted(of: Line, width: int) -> Line:
    """Return a line of exactly `width` cells: cut, or filled with blanks."""
    left = width
    spans: list[Span] = []
    for span in of:
        size = cells(span.text)
        if size > left:
            text = _first_cells(span.text, left)
            left -= cells(text)
            if text:
                spans.append(Span(text, span.ink))
            break
        left -= size
        spans.append(span)
    if left > 0:
        spans.append(Span(" " * left))
    return tuple(spans)


def joined(parts: Iterable[Line]) -> Line:
    """Return one line of several."""
    return tuple(span for part in parts for span in part)


def _first_cells(text: str, width: int) -> str:
    if text.isascii():
        return text[: max(0, width)]
    taken: list[str] = []
    for character in text:
        width -= _cells_of(character)
        if width < 0:
            break
        taken.append(character)
    return "".join(taken)


def _cells_of(character: str) -> int:
    if combining(character):
        return 0
    return 2 if east_asian_width(character) in "WF" else 1
