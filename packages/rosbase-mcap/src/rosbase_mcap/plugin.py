"""Register the commands for recordings. Imports no more than the command that runs needs."""

import argparse
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from rosbase import CommandPlugin, hookimpl

__all__ = ["rosbase_commands"]

_COMMANDS = (
    ("record", "record the topics of a running program", "record_command"),
    ("recover", "mend a recording that was cut off", "recover_command"),
    ("info", "say what is in a recording", "info_command"),
    ("cut", "copy a part of a recording", "cut_command"),
    ("export", "write the messages of a recording as tables", "export_command"),
)


def _command(name: str, summary: str, module: str) -> CommandPlugin:
    module = f"rosbase_mcap.commands.{module}"

    def configure(parser: argparse.ArgumentParser) -> None:
        import_module(module).configure(parser)

    def run(arguments: Any) -> int:
        status: int = import_module(module).run(arguments)
        return status

    return CommandPlugin(name, summary, configure, run)


@hookimpl
def rosbase_commands() -> Iterable[CommandPlugin]:
    """Return the commands for recordings."""
    return [_command(*command) for command in _COMMANDS]
