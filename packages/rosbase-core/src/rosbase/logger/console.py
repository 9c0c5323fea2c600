"""The console: writes log lines while the application has set up no logging of its own."""

import logging
import os
import sys
from collections.abc import Callable
from typing import TextIO

from rosbase.logger.formatter import RosFormatter

__all__ = ["Console", "current_console", "use_console", "wants_colour"]


class Console(logging.Handler):
    """Writes records in the format of ROS 2, to stderr if nothing else is given."""

    def __init__(
        self, write: Callable[[str], object] | None = None, *, has_colour: bool | None = None
    ) -> None:
        """Take the function that writes lines.

        Args:
            write: Called with each text, line end included.
            has_colour: Whether to colour lines by level; by default on a terminal.
        """
        super().__init__()
        self._write = write
        self._has_colour = _said_of_colour() if has_colour is None else has_colour
        self._goes_to_stdout = os.environ.get("RCUTILS_LOGGING_USE_STDOUT") == "1"
        self._plain, self._coloured = RosFormatter(), RosFormatter(has_colour=True)

    def emit(self, record: logging.LogRecord) -> None:
        """Write one record."""
        # Looked up each time, because a program may put another stream there, or none.
        stream: TextIO | None = sys.stdout if self._goes_to_stdout else sys.stderr
        try:
            has_colour = self._has_colour
            if has_colour is None:
                has_colour = stream is not None and stream.isatty()
            text = (self._coloured if has_colour else self._plain).format(record) + "\n"
            if self._write is not None:
                self._write(text)
            elif stream is not None:
                stream.write(text)
                stream.flush()
        except (OSError, ValueError):
            # Nobody can hear it: the stream is closed, or its reader has gone.
            pass


_console: list[Console] = []


def current_console() -> Console:
    """Return the console of this process; create it on first use."""
    if not _console:
        _console.append(Console())
    return _console[0]


def use_console(console: Console | None) -> None:
    """Write log lines with this console; None stands for the usual one."""
    _console[:] = [] if console is None else [console]


def wants_colour(stream: TextIO) -> bool:
    """Return whether lines for a stream have colours.

    `RCUTILS_COLORIZED_OUTPUT` turns them off or on with 0 or 1. Otherwise a terminal has
    colours, unless `NO_COLOR` is set.
    """
    said = _said_of_colour()
    return stream.isatty() if said is None else said


def _said_of_colour() -> bool | None:
    said = os.environ.get("RCUTILS_COLORIZED_OUTPUT")
    if said in ("0", "1"):
        return said == "1"
    return False if os.environ.get("NO_COLOR") else None
