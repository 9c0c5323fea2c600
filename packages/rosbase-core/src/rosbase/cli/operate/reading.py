"""Read a command line by the table of commands. Pure."""

from __future__ import annotations

from rosbase.cli.operate.entries import Command, Group, Option
from rosbase.cli.operate.words import GROUPS, all_options

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["Given", "UsageError", "WantsHelp", "find", "read"]

_MOST_DIGITS = 18


class UsageError(Exception):
    """A command line that the user must correct. The text is one line."""


class WantsHelp(Exception):  # noqa: N818 - it is no error
    """The user asks for help instead of the command."""


class Given:
    """The values of a command line, as attributes."""

    def __init__(self, values: dict[str, object]) -> None:
        self.__dict__.update(values)

    def __getattr__(self, name: str) -> object:
        raise AttributeError(f"the command has no {name}")


def find(words: list[str]) -> tuple[str, Command | Group, list[str]]:
    """Return the command that the first words name, its words, and the words after them.

    A group is returned if no word follows, or one that asks for help.

    Raises:
        UsageError: There is no such command.
    """
    first, rest = words[0], words[1:]
    entry = GROUPS[first]
    if isinstance(entry, Command):
        return first, entry, rest
    if not rest or rest[0] in ("-h", "--help"):
        return first, entry, rest
    if rest[0] not in entry.commands:
        text = f"no command '{first} {rest[0]}'; there are: {', '.join(entry.commands)}"
        raise UsageError(text)
    return f"{first} {rest[0]}", entry.commands[rest[0]], rest[1:]


def read(command: Command, words: list[str]) -> dict[str, object]:
    """Return the values of arguments and options by name, with the defaults of those left out.

    Options may stand anywhere; after `--`, every word is an argument.

    Raises:
        UsageError: An option or value is wrong, or an argument is missing or too many.
        WantsHelp: There is `-h` or `--help`.
    """
    values: dict[str, object] = {o.key: [] if o.many else o.default for o in all_options(command)}
    arguments = _read_options(command, list(words), values)
    for argument in command.arguments:
        if argument.rest:
            values[argument.key], arguments = arguments, []
        else:
            values[argument.key] = arguments.pop(0) if arguments else None
        if argument.needed and not values[argument.key]:
            # An empty text is as good as none: no name is empty.
            raise UsageError(f"{argument.key.upper()} is missing; see --help")
    if arguments:
        raise UsageError(f"unrecognized arguments: {' '.join(arguments)}")
    return values


def _read_options(command: Command, words: list[str], values: dict[str, object]) -> list[str]:
    """Take the options from the words; return the arguments."""
    known = {flag: option for option in all_options(command) for flag in option.flags}
    arguments: list[str] = []
    while words:
        word = words.pop(0)
        if word == "--":
            return arguments + words
        if not word.startswith("-") or word == "-" or _is_value(word, known):
            arguments.append(word)
            continue
        if word in ("-h", "--help"):
            raise WantsHelp
        for flag, attached in _flags(word, known):
            _keep(known[flag], flag, attached, words, values)
    return arguments


def _is_value(word: str, known: Mapping[str, Option]) -> bool:
    """Return whether a word with a dash in front is a number, such as `-5`, `-.inf` or `-0x10`.

    Some commands have an option `-1`.
    """
    return word[:2] not in known and (word[1].isdecimal() or word[1] == "." or _is_number(word))


def _flags(word: str, known: dict[str, Option]) -> list[tuple[str, str | None]]:
    """Return the flags of a word with their attached values: `--rate=5`, `-r5`, `-tc`."""
    if word.startswith("--"):
        flag, equals, value = word.partition("=")
        return [(_full(flag, known), value if equals else None)]
    found: list[tuple[str, str | None]] = []
    for place, letter in enumerate(word[1:], start=2):
        flag = f"-{letter}"
        if flag not in known:
            raise UsageError(f"unrecognized arguments: {word}")
        if known[flag].value:
            return [*found, (flag, word[place:].removeprefix("=") or None)]
        found.append((flag, None))
    return found


def _full(flag: str, known: dict[str, Option]) -> str:
    """Return the long option that a flag is, or of which it is the only beginning."""
    if flag in known:
        return flag
    meant = [name for name in known if name.startswith(flag)]
    if len(meant) == 1:
        return meant[0]
    among = f": could be {', '.join(meant)}" if meant else ""
    raise UsageError(f"unrecognized arguments: {flag}{among}")


def _keep(
    option: Option,
    flag: str,
    attached: str | None,
    words: list[str],
    values: dict[str, object],
) -> None:
    value: object = True
    if option.value:
        if attached is None and not words:
            raise UsageError(f"{flag} takes a value: {option.value}")
        value = _of_kind(option, flag, words.pop(0) if attached is None else attached)
    elif attached is not None:
        raise UsageError(f"{flag} takes no value")
    held = values[option.key]
    if option.many and isinstance(held, list):
        held.append(value)
    else:
        values[option.key] = value


def _of_kind(option: Option, flag: str, text: str) -> object:
    """Return the value in a text."""
    if option.kind == "text":
        return text
    if option.kind == "positive":
        number = float(text) if _is_number(text) else 0.0
        if not 0.0 < number < float("inf"):
            raise UsageError(f"{flag}: '{text}' is not a positive number")
        return number
    least = 1 if option.kind == "whole" else 0
    # Python reads no number of thousands of digits.
    if not text.isdecimal() or len(text) > _MOST_DIGITS or int(text) < least:
        raise UsageError(f"{flag}: '{text[:80]}' is not a whole number from {least} up")
    return int(text)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
