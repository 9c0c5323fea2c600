"""Options of `rosbase view`, as the user gave them. Pure."""

import argparse
from collections.abc import Callable

from attrs import frozen

__all__ = [
    "FOXGLOVE_PORT",
    "LOOPBACK",
    "RECORDING",
    "WEB_PORT",
    "Options",
    "add_arguments",
    "options_of",
]

LOOPBACK = "127.0.0.1"
RECORDING = ".mcap"
"""End of the name of a recording."""
WEB_PORT = 8080
FOXGLOVE_PORT = 8765


@frozen
class Options:
    """The chosen view, its subject, and its address."""

    view: str
    """`terminal`, `web` or `foxglove`."""
    name: str | None
    """A program, the pid of its process, or the path of a recording; None for all programs."""
    host: str
    """Address to listen on."""
    port: int
    """Port to listen on."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "name",
        nargs="?",
        metavar="NAME",
        help="a program, or the pid of its process, with its child processes (default: all); or a"
        " recording, such as field.mcap",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--web",
        nargs="?",
        const="",
        metavar="PORT",
        help=f"show a page for browsers, on this port (default: {WEB_PORT})",
    )
    where.add_argument(
        "--foxglove",
        nargs="?",
        const="",
        metavar="PORT",
        help=f"serve Foxglove, Lichtblick and PlotJuggler, on this port (default: {FOXGLOVE_PORT})",
    )
    parser.add_argument(
        "--host",
        default=LOOPBACK,
        metavar="ADDRESS",
        help=f"with --web or --foxglove: address to listen on (default: {LOOPBACK})",
    )


def options_of(arguments: argparse.Namespace, on_mistake: Callable[[str], object]) -> Options:
    """Return the options that the arguments give.

    Args:
        arguments: As `add_arguments` has them parsed.
        on_mistake: Called with a line if they do not go together; it must raise.
    """
    if arguments.web is not None:
        view, given, default = "web", arguments.web, WEB_PORT
    elif arguments.foxglove is not None:
        view, given, default = "foxglove", arguments.foxglove, FOXGLOVE_PORT
    else:
        return Options("terminal", arguments.name, arguments.host, 0)
    name: str | None = arguments.name
    if given and not given.isdecimal():
        # `--web quadruped`: a name is no port. But it begins with a letter, as in ROS.
        if name is not None or (given[0] in "+-0123456789" and not given.endswith(RECORDING)):
            on_mistake(f"{given!r} is no port")
        given, name = "", given
    port = int(given) if given else default
    if port > 65_535:
        on_mistake(f"there is no port {port}")
    return Options(view, name, arguments.host, port)
