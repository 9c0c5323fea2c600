"""Registers the commands of the core. What they need is imported when they run."""

import argparse
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from rosbase.plugins import CommandPlugin, hookimpl

__all__ = ["rosbase_commands"]

_COMMANDS = (
    ("imu", "read an IMU and publish what it measures", "rosbase.cli.imu"),
    ("demo", "read a simulated IMU over a real link", "rosbase.cli.demo"),
    ("plugins", "list the installed plugins", "rosbase.cli.list_plugins"),
)


def _command(name: str, summary: str, module: str) -> CommandPlugin:
    def configure(parser: argparse.ArgumentParser) -> None:
        import_module(module).configure(parser)

    def run(arguments: Any) -> int:
        status: int = import_module(module).run(arguments)
        return status

    return CommandPlugin(name, summary, configure, run)


@hookimpl
def rosbase_commands() -> Iterable[CommandPlugin]:
    """The commands of the core."""
    return [_command(*command) for command in _COMMANDS]
