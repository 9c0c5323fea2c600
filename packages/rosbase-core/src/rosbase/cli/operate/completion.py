"""`rosbase completion`: scripts for shells, and the hidden command that they ask at each Tab.

The scripts know nothing of commands. At each Tab they run `rosbase _complete WORDS...`, which
prints the candidates for the last word, one a line, each with a tab and what it is.
"""

from __future__ import annotations

import sys

from rosbase.cli.operate.entries import Argument, Command, Option
from rosbase.cli.operate.reading import UsageError, find
from rosbase.cli.operate.words import GROUPS, all_options

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable
    from typing import Any

__all__ = ["complete", "show_script"]

_BASH = """\
# bash completion of rosbase: eval "$(rosbase completion bash)"
_rosbase() {
    local IFS=$'\\n' line
    COMPREPLY=()
    for line in $(rosbase _complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null); do
        COMPREPLY+=("${line%%$'\\t'*}")
    done
    # A folder goes on, and so does an option with its value attached.
    [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == */ ]] && compopt -o nospace
    return 0
}
complete -F _rosbase rosbase
"""
_ZSH = """\
#compdef rosbase
# zsh completion of rosbase, after compinit: source <(rosbase completion zsh)
_rosbase() {
    local -a lines values shown
    lines=("${(@f)$(rosbase _complete "${(@)words[2,CURRENT]}" 2>/dev/null)}")
    lines=(${lines:#})
    (( $#lines )) || return 1
    values=("${(@)lines%%$'\\t'*}")
    shown=("${(@)lines/$'\\t'/  -- }")
    if [[ $#values -eq 1 && $values[1] == */ ]]; then
        compadd -S '' -d shown -a values
    else
        compadd -d shown -a values
    fi
}
compdef _rosbase rosbase
"""
_FISH = """\
# fish completion of rosbase: rosbase completion fish | source
function __rosbase_complete
    set -l words (commandline -opc) (commandline -ct)
    rosbase _complete $words[2..-1] 2>/dev/null
end
complete -c rosbase -e
complete -c rosbase -f -a '(__rosbase_complete)'
"""
# Commands of plugins whose arguments are files, and options whose values are.
_OF_FILES = ("run", "up")
_FILE_FLAGS = ("--params-file", "--log-file")
_SCRIPTS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}


def show_script(given: Any) -> None:
    """Print the script for a shell.

    Raises:
        UsageError: There is none for it.
    """
    if given.shell not in _SCRIPTS:
        raise UsageError(f"there is a script for bash, zsh and fish, not for '{given.shell}'")
    print(_SCRIPTS[given.shell], end="")


def complete(words: list[str]) -> int:
    """Print the candidates for the last word; the words are those after `rosbase`."""
    *before, current = words or [""]
    try:
        found = list(_candidates(before, current))
    except Exception:
        # A shell has no place for an error at a Tab.
        found = []
    for word, what in found:
        if word.startswith(current):
            print(f"{word}\t{what}" if what else word)
    sys.stdout.flush()
    return 0


def _candidates(before: list[str], current: str) -> Iterable[tuple[str, str]]:
    if before and before[0] in GROUPS:
        return _of_quick(before, current)
    from rosbase.cli.operate.other_commands import (
        commands,
        options,
    )

    if not before and current.startswith("-"):
        return [("--help", "show the commands and end"), ("--version", "print the version and end")]
    if not before:
        ours = [(name, entry.summary) for name, entry in GROUPS.items()]
        return sorted({**dict(ours), **commands()}.items())
    if not current.startswith("-") and (before[0] in _OF_FILES or before[-1] in _FILE_FLAGS):
        return _names("files", [], None, current)
    return options(before[0])


def _of_quick(before: list[str], current: str) -> Iterable[tuple[str, str]]:
    entry = GROUPS[before[0]]
    if not isinstance(entry, Command) and len(before) == 1:
        return [(word, command.summary) for word, command in entry.commands.items()]
    _, command, rest = find(before)
    if not isinstance(command, Command):
        return []
    arguments, option, program = _read_so_far(command, rest)
    flag, equals, _ = current.partition("=")
    known = {name: one for one in all_options(command) for name in one.flags}
    if option is None and equals and flag in known:
        values = _names(known[flag].completes, arguments, program, current)
        return [(f"{flag}={word}", what) for word, what in values]
    if option is not None:
        return _names(option.completes, arguments, program, current)
    if current.startswith("-"):
        return [(one.flags[-1], one.help) for one in all_options(command)]
    argument = _argument_at(command, len(arguments))
    # Of names and values in turn, only the names are known.
    if argument is None or (argument.key == "name_and_value" and len(arguments) % 2 == 0):
        return []
    return _names(argument.completes, arguments, program, current)


def _read_so_far(command: Command, words: list[str]) -> tuple[list[str], Option | None, str | None]:
    """Return the arguments so far, the option whose value comes next, and the program."""
    known = {flag: option for option in all_options(command) for flag in option.flags}
    arguments: list[str] = []
    waiting: Option | None = None
    program = None
    for word in words:
        flag, equals, value = word.partition("=")
        if waiting is not None:
            program = word if waiting.key == "program" else program
            waiting = None
        elif flag in known:
            if known[flag].value and not equals:
                waiting = known[flag]
            elif known[flag].key == "program":
                program = value
        elif not word.startswith("-"):
            arguments.append(word)
    return arguments, waiting, program


def _argument_at(command: Command, number: int) -> Argument | None:
    if number < len(command.arguments):
        return command.arguments[number]
    last = command.arguments[-1] if command.arguments else None
    return last if last is not None and last.rest else None


def _names(
    kind: str, arguments: list[str], program: str | None, current: str
) -> list[tuple[str, str]]:
    """Return live names of a kind, or the words that it is."""
    from rosbase.cli.operate import live_names

    look_up = getattr(live_names, kind, None)
    if look_up is None:
        return [(word, "") for word in kind.split()]
    found: list[tuple[str, str]] = look_up(arguments, program, current)
    # People leave out the slash in front.
    if not current.startswith("/") and current and kind in live_names.WITH_SLASH:
        found = [(name.removeprefix("/"), what) for name, what in found]
    return found
