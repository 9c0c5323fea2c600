"""Characters that a terminal can show."""

from attrs import frozen

__all__ = ["ASCII", "UNICODE", "Glyphs"]


@frozen
class Glyphs:
    """Characters for pictures."""

    levels: str
    """From none to most of a cell, for sparklines; two rows of them do not touch."""
    block: str
    half: str
    """Left half of a block; as wide as a block for a terminal that has none."""
    middle: str
    chosen: str
    """In front of the chosen row, which so stands out without colour."""
    opened: str
    closed: str
    bar: str
    """Between two panes that are beside each other."""
    rule: str
    """Between two panes, one above the other."""
    has_dots: bool
    """Whether a cell can show a pattern of 2 by 4 dots."""


UNICODE = Glyphs(" ▁▂▃▄▅▆▇", "█", "▌", "│", "▶", "▾", "▸", "│", "─", has_dots=True)
ASCII = Glyphs(" .:-=+*%#", "#", "#", "|", ">", "v", ">", "|", "-", has_dots=False)
