"""The command `rosbase`: thin; what it does is done by the floors below."""

import os
import sys
from collections.abc import Sequence

from rosbase.cli.arguments import OneLineParser
from rosbase.errors import RosbaseError
from rosbase.plugins import installed_plugins

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command line; gives the exit status.

    What a user can mend is one line on stderr and status 2, never a traceback.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        return _run(arguments)
    except RosbaseError as error:
        print(f"rosbase: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        return 0
    finally:
        _forget_broken_stdout()


def _run(arguments: list[str]) -> int:
    commands = installed_plugins().commands
    parser = OneLineParser(
        prog="rosbase", description="A framework for robot applications, with or without ROS."
    )
    parser.add_argument("--version", action="store_true", help="print the version and end")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND")
    for name, command in sorted(commands.items()):
        subparser = subparsers.add_parser(name, help=command.summary, description=command.summary)
        # Only the command that is asked for imports what it needs.
        if name in arguments:
            command.configure(subparser)
    parsed = parser.parse_args(arguments)
    if parsed.version:
        print(_version())
        return 0
    if parsed.command is None:
        parser.error(f"say what to do: {', '.join(sorted(commands))}; --help says more")
    return commands[parsed.command].run(parsed)


def _version() -> str:
    from importlib.metadata import version

    return f"rosbase-core {version('rosbase-core')}"


def _forget_broken_stdout() -> None:
    """Keeps the interpreter from complaining at exit about a pipe that nobody reads."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
