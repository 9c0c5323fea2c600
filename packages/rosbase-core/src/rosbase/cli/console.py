"""The log of a command on stderr: in the format of ROS 2, above the lines shown on a terminal."""

import argparse
import logging
import sys
from collections.abc import Iterable

from rosbase.cli.output import Output
from rosbase.cli.panel.fields import wrapped
from rosbase.cli.screen import Screen
from rosbase.logger import Console, level_number, use_console
from rosbase.logger.console import wants_colour
from rosbase.logger.environment import apply_environment

__all__ = ["LogOutput", "add_log_level", "log_to_stderr"]


class LogOutput(Output):
    """Output of the log: it never waits, and on a terminal it appears above the shown lines."""

    screen: Screen | None = None
    """Screen whose lines make room for the log."""
    wraps = False
    """Whether long lines break between words at the width of the terminal."""

    def write_record(self, text: str) -> None:
        """Write the lines of a record."""
        if self.wraps and self.is_terminal:
            width = self.size[0] - 1
            text = "".join(f"{wrapped(line, width)}\n" for line in text.splitlines())
        if self.screen is None:
            self.write(text)
        else:
            self.screen.above(self, text)


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
    """Write rosbase's log records to stderr, whatever libraries do; return the output.

    Args:
        levels: The minimum level of each logger, by its name; the empty name stands for all.
    """
    output = LogOutput(sys.stderr)
    console = Console(output.write_record, has_colour=wants_colour(sys.stderr))
    use_console(console)
    logger = logging.getLogger("rosbase")
    logger.handlers[:] = [console]
    # The command is the application here, so what a plugin does to the root does not matter.
    logger.propagate = False
    logger.setLevel(logging.NOTSET)
    # Before the command line's, which win.
    apply_environment()
    for name, level in levels:
        (logger.getChild(name) if name else logger).setLevel(level)
    return output


def _named_level(text: str) -> tuple[str, int]:
    name, _, level = text.rpartition(":=")
    try:
        return name, level_number(level)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
