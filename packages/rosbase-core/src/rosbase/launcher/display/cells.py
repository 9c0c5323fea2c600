"""How wide text is on a terminal: in its cells, of which some characters take two."""

import unicodedata

__all__ = ["cut", "padded", "width"]

_CUT = "..."


def width(text: str) -> int:
    """Return the number of cells that a line without control characters takes."""
    return len(text) if text.isascii() else sum(map(_width, text))


def cut(text: str, most: int) -> str:
    """Return the text if it takes at most that many cells, and otherwise its beginning and `...`.

    The result never takes more cells than `most`.
    """
    if width(text) <= most:
        return text
    room = most - len(_CUT)
    kept = []
    for character in text:
        room -= _width(character)
        if room < 0:
            break
        kept.append(character)
    return ("".join(kept) + _CUT)[: max(0, most)]


def padded(text: str, cells: int) -> str:
    """Return the text with blanks behind it, so that it takes at least that many cells."""
    return text + " " * (cells - width(text))


def _width(character: str) -> int:
    if unicodedata.category(character) in ("Mn", "Me"):
        # It is drawn over the character before it.
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1
