"""The help of the commands, made from their table. Pure."""

from rosbase.cli.operate.entries import Command, Group
from rosbase.cli.operate.words import all_options

__all__ = ["command_help", "group_help", "usage"]

_INDENT = "  "
_GAP = 2


def usage(name: str, command: Command) -> str:
    """Return the line that shows how to write a command."""
    arguments = " ".join(argument.shown for argument in command.arguments)
    return f"usage: rosbase {name} [OPTIONS] {arguments}".rstrip()


def command_help(name: str, command: Command) -> str:
    """Return the help of a command."""
    parts = [usage(name, command), "", f"{_sentence(command.summary)}"]
    if command.arguments:
        rows = [(argument.shown.strip("[]"), argument.help) for argument in command.arguments]
        parts += ["", "arguments:", *_columns(rows)]
    rows = [
        (", ".join(option.flags) + (f" {option.value}" if option.value else ""), option.help)
        for option in all_options(command)
    ]
    return "\n".join([*parts, "", "options:", *_columns(rows)])


def group_help(name: str, group: Group) -> str:
    """Return the help of a group of commands."""
    rows = [(word, command.summary) for word, command in group.commands.items()]
    head = [f"usage: rosbase {name} COMMAND ...", "", _sentence(group.summary), ""]
    more = ["", f"`rosbase {name} COMMAND --help` shows the options of a command."]
    return "\n".join([*head, "commands:", *_columns(rows), *more])


def _sentence(summary: str) -> str:
    return f"{summary[0].upper()}{summary[1:]}."


def _columns(rows: list[tuple[str, str]]) -> list[str]:
    width = max(len(left) for left, _ in rows) + _GAP
    return [f"{_INDENT}{left:{width}}{right}" for left, right in rows]
