"""A command run on a terminal of its own, and the last screen that it leaves there as a picture."""

import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator, Sequence
from html import escape
from itertools import groupby
from pathlib import Path

import pyte
from pyte.screens import Char

__all__ = ["draw", "last_screen", "run"]

Line = Sequence[Char]
"""The characters of one row of the screen, each with its colour."""

_ROWS = 60
# pyte knows no dim text, so that is shown in the grey of terminals.
_DIM, _GREY = re.compile(rb"\x1b\[2(;39;49)?m"), b"\x1b[90m"

_CELL, _ROW, _MARGIN = 8.4, 19, 14
_COLOURS = {
    "default": "#d4dae3",
    "brightblack": "#8b95a5",
    "cyan": "#4cc2d6",
    "blue": "#6fa8f5",
    "magenta": "#c88be8",
    "green": "#5fcf80",
    "brown": "#e0b354",
    "red": "#f2777a",
}
_GROUND = "#171a21"
# Bars are drawn, because few fonts have blocks without gaps: where one begins, and how wide it is.
_BLOCKS = {"█": (0.0, 1.0), "▌": (0.0, 0.5), "▐": (0.5, 0.5), "│": (0.45, 0.1)}
# The same for bars that stand beside each other, of so many eighths.
_LEVELS = {level: eighths for eighths, level in enumerate("▁▂▃▄▅▆▇", 1)}
# Lines that cells continue.
_RULE = "─"
_DRAWN = "".join((*_BLOCKS, *_LEVELS, _RULE)) + "\u2800-\u28ff"
_WORD = rf"[^\s{_DRAWN}]+"
_PARTS = re.compile(rf"{_RULE}+|[{_DRAWN}]|{_WORD}(?: {_WORD})*")
# Columns and rows of the dots of a cell, as Unicode numbers them.
_DOTS = ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3))


def run(*command: str, columns: int) -> bytes:
    """Run a command of this environment on a terminal, and return all that it wrote."""
    near, far = pty.openpty()
    fcntl.ioctl(far, termios.TIOCSWINSZ, struct.pack("4H", _ROWS, columns, 0, 0))
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    plain = {name: value for name, value in os.environ.items() if name != "NO_COLOR"}
    settings = {"PATH": path, "TERM": "xterm-256color", "PYTHONUTF8": "1", "TMPDIR": "/tmp"}
    with subprocess.Popen(
        command, stdin=far, stdout=far, stderr=far, env={**plain, **settings}
    ) as process:
        os.close(far)
        written = b"".join(_read(near, process))
        os.close(near)
    if process.returncode:
        raise RuntimeError(f"{command} ended with status {process.returncode}: {written!r}")
    return written


def _read(descriptor: int, process: subprocess.Popen[bytes]) -> Iterator[bytes]:
    """Yield what is written, until the process has ended and everything is read."""
    readable = select.poll()
    readable.register(descriptor, select.POLLIN)
    while True:
        has_ended = process.poll() is not None
        if readable.poll(0 if has_ended else 50):
            try:
                yield os.read(descriptor, 4_096)
            except OSError:
                # Nobody has the other end any more.
                return
        elif has_ended:
            return


def last_screen(written: bytes, columns: int, height: int = _ROWS) -> list[Line]:
    """Return the rows that the terminal shows in the end, without the empty ones below."""
    screen = pyte.Screen(columns, height)
    pyte.ByteStream(screen).feed(_DIM.sub(_GREY, written))
    rows = (screen.buffer[number] for number in range(height))
    lines: list[Line] = [[row[column] for column in range(columns)] for row in rows]
    while lines and not _text(lines[-1]).strip():
        lines.pop()
    return lines


def draw(lines: Sequence[Line], title: str, *, attributes: str = "", style: str = "") -> str:
    """Return an SVG of these rows, as wide as the longest of them.

    Args:
        lines: The rows from the top.
        title: What the picture is called for those who do not see it.
        attributes: More attributes of the `svg` element.
        style: A style sheet to go with it.
    """
    columns = max(len(_text(line).rstrip()) for line in lines)
    width = columns * _CELL + 2 * _MARGIN
    height = len(lines) * _ROW + 2 * _MARGIN
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height}"'
        f' role="img"{attributes and " " + attributes}>',
        f"<title>{escape(title)}</title>",
        *([f"<style>{style}</style>"] if style else []),
        f'<rect width="{width:.0f}" height="{height}" rx="8" fill="{_GROUND}"/>',
        '<g font-family="ui-monospace, SFMono-Regular, Menlo, DejaVu Sans Mono, monospace"'
        ' font-size="14">',
        *(part for number, line in enumerate(lines) for part in _draw_line(number, line)),
        "</g>",
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _text(line: Line) -> str:
    return "".join(char.data for char in line)


def _draw_line(number: int, line: Line) -> Iterator[str]:
    """Yield the words of a row, and its bars, each at its column."""
    top = _MARGIN + number * _ROW
    column = 0
    for (colour, is_bold, is_chosen), chars in groupby(
        line, key=lambda char: (char.fg, char.bold, char.reverse)
    ):
        text = _text(list(chars))
        ink = _COLOURS[colour]
        if is_chosen:
            left, width = _MARGIN + column * _CELL, len(text) * _CELL
            yield _draw_rectangle(left, top, width, _ROW, f'fill="{ink}"')
            ink = _GROUND
        fill = f'fill="{ink}"' + (' font-weight="bold"' if is_bold else "")
        for match in _PARTS.finditer(text):
            left = _MARGIN + (column + match.start()) * _CELL
            yield _draw_part(match[0], left, top, fill)
        column += len(text)


def _draw_part(text: str, left: float, top: int, fill: str) -> str:
    if text in _BLOCKS:
        begin, width = (part * _CELL for part in _BLOCKS[text])
        return (
            f'<rect x="{left + begin:.1f}" y="{top + 2}" width="{width + 0.05:.2f}"'
            f' height="{_ROW - 4}" {fill}/>'
        )
    if text in _LEVELS:
        height = _LEVELS[text] * _ROW / 8
        return _draw_rectangle(left, top + _ROW - height, _CELL + 0.05, height, fill)
    if text[0] == _RULE:
        return _draw_rectangle(left, top + 9, len(text) * _CELL, 1, fill)
    if "\u2800" <= text <= "\u28ff":
        return _draw_dots(ord(text) - 0x2800, left, top, fill)
    # Whatever the font, a word is as wide as its columns.
    return (
        f'<text x="{left:.1f}" y="{top + 14}" textLength="{len(text) * _CELL:.1f}"'
        f' lengthAdjust="spacingAndGlyphs" {fill}>{escape(text)}</text>'
    )


def _draw_rectangle(left: float, top: float, width: float, height: float, fill: str) -> str:
    return f'<rect x="{left:.1f}" y="{top:.1f}" width="{width:.2f}" height="{height:.1f}" {fill}/>'


def _draw_dots(bits: int, left: float, top: int, fill: str) -> str:
    """Return a cell of braille as squares, so that neighbouring cells meet."""
    width, height = _CELL / 2, _ROW / 4
    side = f"h{width * 0.8:.1f}v{height * 0.8:.1f}h-{width * 0.8:.1f}z"
    squares = "".join(
        f"M{left + column * width:.1f} {top + row * height:.1f}{side}"
        for number, (column, row) in enumerate(_DOTS)
        if bits >> number & 1
    )
    return f'<path d="{squares}" {fill}/>'
