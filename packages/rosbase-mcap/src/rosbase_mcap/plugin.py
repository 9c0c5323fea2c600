"""Register the recorder and the commands. Imports no more than what runs needs."""

import argparse
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from rosbase import CommandPlugin, RecorderPlugin, Recording, RecordOptions, hookimpl

__all__ = ["rosbase_commands", "rosbase_recorders"]

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


def _open(options: RecordOptions) -> Recording:
    module = import_module("rosbase_mcap.program_recording")
    recording: Recording = module.ProgramRecording(options)
    return recording


@hookimpl
def rosbase_recorders() -> Iterable[RecorderPlugin]:
    """Return the recorder of MCAP files."""
    return [RecorderPlugin("mcap", "recordings that ros2 bag and Foxglove open", _open)]
