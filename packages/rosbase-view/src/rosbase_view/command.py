"""`rosbase view`: look at running programs in a terminal."""

import argparse
import os
import sys
from typing import Any

from rosbase import ConfigurationError, SystemClock
from rosbase_view.attached.source import AttachedSource
from rosbase_view.drawing.glyphs import ASCII, UNICODE

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "name",
        nargs="?",
        metavar="NAME",
        help="a program, or the pid of its process; with its child processes (default: all)",
    )


def run(arguments: Any) -> int:
    """Show the view until the user ends it.

    Raises:
        ConfigurationError: There is no terminal.
        ControlError: No program has that name, or several have.
    """
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise ConfigurationError("rosbase view needs a terminal")
    # Before the screen changes, so that a wrong name is one line.
    source = AttachedSource(arguments.name)
    source.check()
    # textual takes a tenth of a second to import.
    from rosbase_view.terminal.app import ViewApp  # noqa: PLC0415 - not for a mistake

    glyphs = UNICODE if _is_utf8() else ASCII
    app = ViewApp(source, SystemClock(), glyphs)
    app.run()
    return app.return_code or 0


def _is_utf8() -> bool:
    """Return whether the terminal shows more than ASCII, as far as the environment tells."""
    encoding = (sys.stdout.encoding or "").lower().replace("-", "")
    # The console of Linux has a font of 256 characters.
    return encoding == "utf8" and os.environ.get("TERM") != "linux"
