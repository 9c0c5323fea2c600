"""Lines with the name of their program, each name in a colour of its own."""

import logging
from collections.abc import Sequence

from rosbase.cli.panel.style import Style
from rosbase.launcher.display.cells import cut, padded, width
from rosbase.text.printable import log_line

__all__ = ["Labels"]

# Red is for errors.
_COLOURS = ("cyan", "green", "yellow", "magenta", "blue")
_WIDEST = 24
_OUTPUT, _NEWS = "|", "*"


class Labels:
    """Makes the lines of some programs."""

    def __init__(self, keys: Sequence[str], style: Style) -> None:
        """Choose the colours.

        Args:
            keys: Keys of all programs, in the order of the file.
            style: What the terminal supports.
        """
        self.width = min(_WIDEST, max(map(width, keys), default=0))
        """Width of the names, in cells of the terminal."""
        self._style = style
        self._colours = {key: _COLOURS[n % len(_COLOURS)] for n, key in enumerate(keys)}

    def name(self, key: str) -> str:
        """Return the name of a program, cut or padded to the width, and in its colour."""
        return self._paint(key, padded(cut(key, self.width), self.width))

    def output(self, key: str, text: str, *, is_error: bool) -> str:
        """Return a line of a program's output."""
        return self._line(key, _OUTPUT, text, ("red",) if is_error else ())

    def news(self, key: str, level: int, text: str) -> str:
        """Return a line about a program."""
        colour = ("red",) if level >= logging.ERROR else ("bold",)
        return self._line(key, _NEWS, text, ("yellow",) if level == logging.WARNING else colour)

    def _line(self, key: str, separator: str, text: str, colours: tuple[str, ...]) -> str:
        name = self._paint(key, padded(key, self.width))
        return f"{name} {separator} {self._style.paint(log_line(text), *colours)}"

    def _paint(self, key: str, name: str) -> str:
        return self._style.paint(name, self._colours.get(key, "cyan"))
