"""The terminal: a line that lives where there is one, plain lines where there is none."""

import argparse
import logging
import shutil
import sys
from collections.abc import Iterable

from rosbase.cli.output import Output
from rosbase.logger import Console, level_number, use_console
from rosbase.logger.console import wants_colour
from rosbase.text.printable import log_line

__all__ = ["LiveLine", "LogOutput", "add_log_level", "log_to_stderr"]

_CLEAR = "\r\x1b[K"
_TERMINAL_PERIOD_S = 0.2
_PLAIN_PERIOD_S = 1.0


class LiveLine:
    """One line that is written over again on a terminal, and line after line elsewhere."""

    def __init__(self, output: Output) -> None:
        self._output = output
        self._is_shown = False

    @property
    def period_s(self) -> float:
        """How often it is worth showing."""
        return _TERMINAL_PERIOD_S if self._output.is_terminal else _PLAIN_PERIOD_S

    def show(self, text: str) -> None:
        """Shows the text in place of the one before."""
        if self._output.is_terminal:
            width = shutil.get_terminal_size().columns - 1
            self._output.write(f"{_CLEAR}{log_line(text)[:width]}")
            self._is_shown = True
        else:
            self._output.write(f"{log_line(text)}\n")

    def give_way(self) -> str:
        """Return what makes room for another line in its place, if it is shown."""
        if not self._is_shown:
            return ""
        self._is_shown = False
        return _CLEAR

    def end(self) -> None:
        """Leaves the last text standing, and goes on below it."""
        if self._is_shown:
            self._output.write("\n")
            self._is_shown = False


class LogOutput(Output):
    """Where the log goes: it never waits, and on a terminal the live line gives way to it."""

    live_line: LiveLine | None = None

    def write_record(self, text: str) -> None:
        """Write the lines of a record."""
        begin = self.live_line.give_way() if self.live_line and self.is_terminal else ""
        self.write(begin + text)


def add_log_level(parser: argparse.ArgumentParser) -> None:
    """Add the option that sets log levels."""
    parser.add_argument(
        "--log-level",
        metavar="[NAME:=]LEVEL",
        type=_named_level,
        action="append",
        default=[],
        help="log from this level on: debug, info, warn, error, fatal; for one logger with NAME:=",
    )


def log_to_stderr(levels: Iterable[tuple[str, int]] = ()) -> LogOutput:
    """Have rosbase's log records written to stderr, whatever libraries do; return the output.

    Args:
        levels: The least level of each logger, by its name; the empty name stands for all.
    """
    output = LogOutput(sys.stderr)
    console = Console(output.write_record, has_colour=wants_colour(sys.stderr))
    use_console(console)
    logger = logging.getLogger("rosbase")
    logger.handlers[:] = [console]
    # The command is the application here, so what a plugin does to the root does not matter.
    logger.propagate = False
    logger.setLevel(logging.NOTSET)
    for name, level in levels:
        (logger.getChild(name) if name else logger).setLevel(level)
    return output


def _named_level(text: str) -> tuple[str, int]:
    name, _, level = text.rpartition(":=")
    try:
        return name, level_number(level)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
