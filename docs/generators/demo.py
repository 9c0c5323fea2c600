"""Pictures of `rosbase demo`, made from what the command really writes to a terminal."""

from concurrent.futures import ThreadPoolExecutor
from functools import cache

import pyte
from pyte.screens import Char

from generators import terminal

__all__ = ["COLUMNS", "NARROW", "picture", "pictures"]

COMMAND = ("rosbase", "demo", "--duration", "5")
COLUMNS, NARROW = 100, 60
"""Terminals for a page, and for a page on a phone."""

_HEAD = "rosbase demo"
_TITLE = "The last screen of rosbase demo: a live panel, then the verdict, the counts, a next step"
# A browser shows the one that can be read.
_EITHER = (
    ".demo{max-width:100%;height:auto}.demo-narrow{display:none}"
    "@media(max-width:34em){.demo-wide{display:none}.demo-narrow{display:inline}}"
)


def pictures() -> str:
    """Return SVG for a page: one picture for wide windows, and one for narrow ones."""
    with ThreadPoolExecutor() as pool:
        wide, narrow = pool.map(_screen, (COLUMNS, NARROW))
    return terminal.draw(
        wide, _TITLE, attributes='class="demo demo-wide"', style=_EITHER
    ) + terminal.draw(narrow, _TITLE, attributes='class="demo demo-narrow"')


def picture() -> str:
    """Return SVG that is a file of its own."""
    return terminal.draw(_screen(COLUMNS), _TITLE)


@cache
def _screen(columns: int) -> list[terminal.Line]:
    """Run the command; return its own call, and the screen from the panel on."""
    lines = terminal.last_screen(terminal.run(*COMMAND, columns=columns), columns)
    texts = ["".join(char.data for char in line) for line in lines]
    begin = next(row for row, text in enumerate(texts) if text.startswith(_HEAD))
    return [_typed(), *lines[begin:]]


def _typed() -> terminal.Line:
    """The prompt, and what is typed there."""
    screen = pyte.Screen(60, 1)
    pyte.Stream(screen).feed(f"\x1b[90m$\x1b[0m {' '.join(COMMAND)}")
    line: list[Char] = [screen.buffer[0][column] for column in range(60)]
    return line
