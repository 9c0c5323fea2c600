"""Format log lines as ROS 2 does; `RCUTILS_CONSOLE_OUTPUT_FORMAT` changes the format."""

import logging
import os
import re
from collections.abc import Callable
from datetime import datetime
from typing import TypeAlias

from rosbase.logger.levels import severity
from rosbase.text.printable import indented, log_line

__all__ = ["DEFAULT_FORMAT", "RosFormatter"]

DEFAULT_FORMAT = "[{severity}] [{time}] [{name}]: {message}"
"""Default format of rcutils."""

_NS_PER_S = 1_000_000_000
_NS_PER_MS = 1_000_000
# As in rcutils. Whatever else stands in braces stays as it is, and so does what stands behind a
# backslash, of which rcutils loses parts of the format.
_ESCAPES = {"\\a": "\a", "\\b": "\b", "\\n": "\n", "\\r": "\r", "\\t": "\t"}
_COLOURS = {"DEBUG": "\x1b[32m", "INFO": "\x1b[0m", "WARN": "\x1b[33m"}
_RED, _NORMAL, _BOLD = "\x1b[31m", "\x1b[0m", "\x1b[1m"
_INDENT = "  "

_Part: TypeAlias = Callable[[logging.LogRecord], str]


def _time_ns(record: logging.LogRecord) -> int:
    # A float has room for the nanoseconds of a second, but not for those since 1970.
    seconds = int(record.created)
    return seconds * _NS_PER_S + round((record.created - seconds) * _NS_PER_S)


def _time(record: logging.LogRecord) -> str:
    seconds, rest = divmod(_time_ns(record), _NS_PER_S)
    return f"{seconds}.{rest:09}"


def _date(record: logging.LogRecord) -> str:
    seconds, rest = divmod(_time_ns(record), _NS_PER_S)
    return f"{datetime.fromtimestamp(seconds):%Y-%m-%d %H:%M:%S}.{rest // _NS_PER_MS:03}"


_TOKENS: dict[str, _Part] = {
    "severity": lambda record: severity(record.levelno),
    "name": lambda record: log_line(record.name.removeprefix("rosbase.")),
    "message": lambda record: log_line(_message(record)[0]),
    "time": _time,
    "time_as_nanoseconds": lambda record: f"{_time_ns(record):019}",
    "date_time_with_ms": _date,
    "function_name": lambda record: log_line(record.funcName or ""),
    "file_name": lambda record: log_line(record.pathname),
    "line_number": lambda record: str(record.lineno),
}
_PIECES = re.compile("|".join([*(f"{{{token}}}" for token in _TOKENS), *map(re.escape, _ESCAPES)]))


class RosFormatter(logging.Formatter):
    """Formats log records as ROS 2 does: one line each, with a traceback indented below it."""

    def __init__(self, template: str | None = None, *, has_colour: bool = False) -> None:
        """Take the format.

        Args:
            template: The format, as in `RCUTILS_CONSOLE_OUTPUT_FORMAT`, which is the default.
            has_colour: Whether to colour lines by level, as on a terminal.
        """
        super().__init__()
        given = os.environ.get("RCUTILS_CONSOLE_OUTPUT_FORMAT")
        self._parts = _compile(template or given or DEFAULT_FORMAT)
        self._has_colour = has_colour

    def format(self, record: logging.LogRecord) -> str:
        """Return the line of a record, and the lines below it."""
        line = "".join(part if isinstance(part, str) else part(record) for part in self._parts)
        trace = self.formatException(record.exc_info) if record.exc_info else None
        below = (*_message(record)[1:], record.exc_text or trace, record.stack_info)
        text = "\n".join([line, *(_below(lines) for lines in below if lines)])
        if not self._has_colour:
            return text
        colour = _COLOURS.get(severity(record.levelno), _RED)
        bold = _BOLD if getattr(record, "is_important", False) else ""
        return f"{colour}{bold}{text}{_NORMAL}"


def _compile(template: str) -> list[str | _Part]:
    parts: list[str | _Part] = []
    end = 0
    for found in _PIECES.finditer(template):
        piece = found.group()
        parts += [template[end : found.start()], _ESCAPES.get(piece) or _TOKENS[piece[1:-1]]]
        end = found.end()
    return [*parts, template[end:]]


def _message(record: logging.LogRecord) -> list[str]:
    """Return the lines of a message; a logger other than rosbase's may have more than one."""
    return record.getMessage().split("\n")


def _below(text: str) -> str:
    """Return the lines below a record, indented so that none looks like a record."""
    lines = text.split("\n")
    are_indented = all(line.startswith(_INDENT) for line in lines)
    return indented(
        "\n".join(line.removeprefix(_INDENT) for line in lines) if are_indented else text
    )
