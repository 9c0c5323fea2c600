"""Commands that look at running programs, and operate them.

They start as quickly as a small program in Python can: no plugins, no attrs, no argparse. Each
module has the functions of a group, which `words.GROUPS` names.
"""

from __future__ import annotations

import os
import sys

from rosbase.cli.operate.entries import Command
from rosbase.cli.operate.reading import Given, UsageError, WantsHelp, find, read
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from rosbase.cli.operate.entries import Group

__all__ = ["run"]

_INTERRUPTED = 130


def run(words: list[str]) -> int:
    """Run a command line whose first word is in `words.GROUPS`; return the exit status.

    0 is success; 1: something was not found, was refused or failed; 2: a usage error;
    130: Ctrl-C.
    """
    if not _prepare_streams():
        _complain("cannot write: stdout is closed")
        return 1
    try:
        status = _run(words)
        sys.stdout.flush()
    except ControlError as error:
        # The output so far comes first.
        _flush()
        _complain(str(error))
        return 1
    except KeyboardInterrupt:
        _flush()
        return _INTERRUPTED
    except BrokenPipeError:
        # Whoever read has had enough, as `head` does.
        _to_nowhere()
        return 0
    except OSError as error:
        if error.filename is not None:
            raise
        _to_nowhere()
        _complain(f"cannot write: {error.strerror}")
        return 1
    return status


def _prepare_streams() -> bool:
    """Have any text printed without an error; return whether there is a place to print it."""
    if sys.stderr is None:
        # `print` would take stdout instead.
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - until the end
    if sys.stdout is None:
        return False
    if sys.stdout.errors == "strict" and hasattr(sys.stdout, "reconfigure"):
        # Not every text of a program is in every character set, as for stderr.
        sys.stdout.reconfigure(errors="backslashreplace")
    return True


def _run(words: list[str]) -> int:
    if words[0] == "_complete":
        # What the scripts of `rosbase completion` ask at each Tab.
        from rosbase.cli.operate.completion import complete

        return complete(words[1:])
    try:
        name, command, rest = find(words)
    except UsageError as error:
        return _misused(words[0], str(error))
    if not isinstance(command, Command):
        return _show_group(name, command, wanted=bool(rest))
    try:
        values = read(command, rest)
        module, _, function = command.does.partition(".")
        found = __import__(f"rosbase.cli.operate.{module}", fromlist=[function])
        status: int | None = getattr(found, function)(Given(values))
        return status or 0
    except UsageError as error:
        return _misused(name, str(error))
    except WantsHelp:
        # Seldom wanted, so not imported for others.
        from rosbase.cli.operate.helping import command_help

        print(command_help(name, command))
        return 0


def _show_group(name: str, group: Group, *, wanted: bool) -> int:
    from rosbase.cli.operate.helping import group_help

    if wanted:
        print(group_help(name, group))
        return 0
    return _misused(name, f"give a command: {', '.join(group.commands)}; see --help")


def _misused(name: str, text: str) -> int:
    print(f"rosbase {name}: {text}", file=sys.stderr)
    return 2


def _complain(line: str) -> None:
    # Names and reasons come from other programs.
    from rosbase.text.printable import MOST_LINE, one_line

    try:
        print(f"rosbase: {one_line(line, MOST_LINE)}", file=sys.stderr, flush=True)
    except OSError:
        # There is nobody to hear it; the exit status says it too.
        pass


def _flush() -> None:
    try:
        sys.stdout.flush()
    except OSError:
        _to_nowhere()


def _to_nowhere() -> None:
    """Keep Python from trying again, at its end, to write what could not be written."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
