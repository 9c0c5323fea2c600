"""Find the command that a command line names, run it, and return its exit status."""

import argparse
import os
import sys
from importlib.metadata import version
from typing import TextIO

from rosbase.cli.arguments import OneLineParser
from rosbase.cli.backend_arguments import check_taken, split_arguments
from rosbase.cli.output import own_stdio
from rosbase.errors import ConfigurationError, ControlError, RosbaseError
from rosbase.plugins import CommandPlugin, installed_plugins
from rosbase.roles.connection import backend_name
from rosbase.text.printable import MOST_LINE, one_line

__all__ = ["run"]

_END = "--"


def run(arguments: list[str]) -> int:
    """Run the command; a usage error becomes one line and status 2."""
    own_stdio()
    try:
        return _run(arguments)
    finally:
        # A complaint that could not be written must not be tried again when Python ends.
        try:
            sys.stderr.flush()
        except OSError:
            _to_nowhere(sys.stderr)


def _run(arguments: list[str]) -> int:
    try:
        status = _run_command(arguments)
        sys.stdout.flush()
    except RosbaseError as error:
        _complain(one_line(str(error), MOST_LINE))
        # What a running program refuses, or does not have, is no wrong use of the command.
        return 1 if isinstance(error, ControlError) else 2
    except BrokenPipeError:
        # Whoever read has had enough, as `head` does. What is left must not be tried again.
        _to_nowhere(sys.stdout)
        return 0
    except OSError as error:
        if error.filename is not None:
            raise
        _to_nowhere(sys.stdout)
        _complain(f"cannot write: {error.strerror}")
        return 1
    return status


def _run_command(arguments: list[str]) -> int:
    registry = installed_plugins()
    commands = registry.commands
    arguments, found, theirs = split_arguments(arguments, registry.backends)
    parser = OneLineParser(
        prog="rosbase", description="A framework for robot applications, with or without ROS."
    )
    parser.add_argument("--version", action="store_true", help="print the version and end")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND")
    wanted = next((word for word in arguments if not word.startswith("-")), None)
    for name, command in sorted(commands.items()):
        summary = command.summary.replace("%", "%%")
        subparser = subparsers.add_parser(name, help=summary, description=summary)
        # Only the command that is asked for imports what it needs.
        if name == wanted:
            _configure(command, subparser)
    if wanted is not None:
        registry.command(wanted)
    chosen = commands.get(wanted or "")
    if chosen is not None and chosen.forwards_backend_arguments and _END in arguments:
        # argparse would drop it.
        at = arguments.index(_END)
        arguments, theirs = arguments[:at], [*arguments[at:], *theirs]
    parsed = parser.parse_args(arguments)
    if parsed.version:
        print(f"rosbase-core {version('rosbase-core')}")
        return 0
    if parsed.command is None:
        parser.error(f"give a command: {', '.join(sorted(commands))}; see --help")
    command = commands[parsed.command]
    if command.forwards_backend_arguments:
        parsed.backend_arguments = theirs
    else:
        check_taken(found, backend_name(getattr(parsed, "backend", None)))
    return command.run(parsed)


def _configure(command: CommandPlugin, parser: argparse.ArgumentParser) -> None:
    try:
        command.configure(parser)
    except Exception as error:
        raise ConfigurationError(f"the command '{command.name}' is broken: {error!r}") from error


def _complain(line: str) -> None:
    try:
        print(f"rosbase: {line}", file=sys.stderr, flush=True)
    except OSError:
        # There is nobody to hear it; the exit status says it too.
        pass


def _to_nowhere(stream: TextIO) -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
