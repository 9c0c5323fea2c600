"""Rows of whole fields, so that no number is ever cut."""

from collections.abc import Iterable
from textwrap import shorten, wrap

from attrs import frozen

from rosbase.cli.panel.style import Style

__all__ = ["Field", "row", "sentence", "wrapped"]

_GAP = "   "


@frozen
class Field:
    """A name and a value, such as `rate` and `100.0 Hz`. Either may be empty."""

    name: str
    value: str = ""
    colours: tuple[str, ...] = ()
    """Colours of the value."""


def row(fields: Iterable[Field], width: int, style: Style) -> str:
    """Return as many of the fields, from the first on, as fit into the width."""
    shown: list[str] = []
    left = width
    for field in fields:
        text = " ".join(part for part in (field.name, field.value) if part)
        left -= len(text) + (len(_GAP) if shown else 0)
        if left < 0:
            break
        colours = field.colours or (() if field.value else ("bold",))
        parts = (
            style.paint(field.name, *(("dim",) if field.value else colours)),
            style.paint(field.value, *colours),
        )
        shown.append(" ".join(part for part in parts if part))
    return _GAP.join(shown)


def sentence(text: str, width: int) -> str:
    """Return the text, cut between two words if it is too long."""
    return shorten(text, width, placeholder=" ...")


def wrapped(text: str, width: int) -> str:
    """Return the text in lines that break between words; lines after the first are indented."""
    lines = wrap(
        text, width, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
    )
    return "\n".join(lines)
