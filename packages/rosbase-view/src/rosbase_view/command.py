"""`rosbase view`: look at running programs in a terminal."""

import argparse
import os
import sys
from typing import Any

from rosbase import ConfigurationError, SystemClock
from rosbase_view.attached.source import AttachedSource
from rosbase_view.drawing.glyphs import ASCII, UNICODE

__all__ = ["configure", "run"]

LOOPBACK = "127.0.0.1"
FOXGLOVE_PORT = 8765
_MOST_PORT = 65_535


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "name",
        nargs="?",
        metavar="NAME",
        help="a program, or the pid of its process; with its child processes (default: all)",
    )
    parser.add_argument(
        "--foxglove",
        nargs="?",
        const="",
        metavar="PORT",
        help="serve Foxglove, Lichtblick and PlotJuggler on this port instead (default: 8765)",
    )
    parser.add_argument(
        "--host",
        default=LOOPBACK,
        help="address on which the server listens; it asks for no password (default: 127.0.0.1)",
    )


def run(arguments: Any) -> int:
    """Show the view until the user ends it.

    Raises:
        ConfigurationError: There is no terminal, the port is in use, or an extra is missing.
        ControlError: No program has that name, or several have.
    """
    if arguments.foxglove is not None:
        return _run_foxglove(arguments)
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


def _run_foxglove(arguments: Any) -> int:
    port, name = _port_and_name(arguments.foxglove, arguments.name)
    try:
        from rosbase_view.foxglove.server import Address  # noqa: PLC0415 - an extra
        from rosbase_view.foxglove.serving import serve  # noqa: PLC0415 - an extra
    except ModuleNotFoundError as error:
        if error.name != "foxglove":
            raise
        raise ConfigurationError(
            "--foxglove needs the package foxglove-sdk: pip install 'foxglove-sdk>=0.30,<0.31'"
        ) from None
    serve(name, Address(arguments.host, port))
    return 0


def _port_and_name(given: str, name: str | None) -> tuple[int, str | None]:
    """Return the port and the program: in `--foxglove robot`, the program follows the option.

    Raises:
        ConfigurationError: It is no port.
    """
    if not given or (name is None and not given.isdecimal()):
        return FOXGLOVE_PORT, given or name
    if not given.isdecimal() or not 0 <= int(given) <= _MOST_PORT:
        raise ConfigurationError(f"--foxglove takes a port from 0 to {_MOST_PORT}, not {given}")
    return int(given), name


def _is_utf8() -> bool:
    """Return whether the terminal shows more than ASCII, as far as the environment tells."""
    encoding = (sys.stdout.encoding or "").lower().replace("-", "")
    # The console of Linux has a font of 256 characters.
    return encoding == "utf8" and os.environ.get("TERM") != "linux"
