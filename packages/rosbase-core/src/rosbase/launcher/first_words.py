"""The files and programs with which commands begin, as far as no shell is needed to tell."""

import re
import shlex
from collections.abc import Iterator

from attrs import frozen

from rosbase.launcher.description import Condition, Program

__all__ = ["Word", "first_words"]

_ASSIGNMENT = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\+?=", re.ASCII)
# Anything of a shell that needs a shell to be understood.
_BY_THE_SHELL = re.compile(r"[$`(){}<>*?\[\]\\!\"']")
_SEPARATORS = re.compile(r"\|\||[;&|\n]")
_BEFORE_A_COMMAND = {"exec", "time", "nohup", "!"}
_EXIT_0 = Condition("exit 0")
_PYTHON = re.compile(r"(?:.*/)?python[0-9.]*")
# Options of Python that have no argument.
_PYTHON_OPTION = re.compile(r"-[bBdEiIOPqsSuvx]+")


@frozen
class Word:
    """A program that a command runs, or a script that it hands to a program; it must exist."""

    program: Program
    text: str
    is_script: bool = False

    @property
    def line(self) -> int:
        """Line of the command in the file."""
        return self.program.lines.get("command", 0)


def first_words(program: Program) -> Iterator[Word]:
    """Yield what the first command of a program needs.

    Later ones may need things that the first one makes, such as a folder, a function or a program
    that it installs. So may any command of a program that waits for the end of another one.
    """
    if not program.commands or _EXIT_0 in program.after.values():
        return
    command = program.commands[0]
    separator = _SEPARATORS.search(command)
    words = _plain_words(command[: separator.start()] if separator else command)
    # With `||`, the user has thought of its absence.
    if not words or (separator and separator[0] == "||"):
        return
    yield Word(program, words[0])
    script = _script_of(words)
    if script and not _BY_THE_SHELL.search(script):
        yield Word(program, script if "/" in script else f"./{script}", is_script=True)


def _plain_words(command: str) -> list[str]:
    try:
        words = shlex.split(command, comments=True)
    except ValueError:
        return []
    while words and (_ASSIGNMENT.match(words[0]) or words[0] in _BEFORE_A_COMMAND):
        del words[0]
    # An option of `exec` or `time` may have an argument.
    if not words or words[0].startswith("-") or _BY_THE_SHELL.search(words[0]):
        return []
    return words


def _script_of(words: list[str]) -> str:
    """Return the script that Python, a shell or `rosbase run` is to run; empty if there is none."""
    ending, rest = ".py", words[1:]
    if _PYTHON.fullmatch(words[0]):
        while rest and _PYTHON_OPTION.fullmatch(rest[0]):
            del rest[0]
    elif words[:2] == ["rosbase", "run"]:
        del rest[0]
    elif words[0] in ("bash", "sh"):
        ending = ".sh"
    else:
        return ""
    is_named = bool(rest) and rest[0].endswith(ending) and not rest[0].startswith("-")
    return rest[0] if is_named else ""
