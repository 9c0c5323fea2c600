"""Register the commands of the core. Their imports happen when they run."""

import argparse
from collections.abc import Iterable
from importlib import import_module
from typing import Any

from rosbase.contracts.checks import CheckContext, Finding
from rosbase.plugins import CheckPlugin, CommandPlugin, hookimpl, installed_plugins

__all__ = ["rosbase_checks", "rosbase_commands"]

_RUNS_PROGRAMS = "run"
_COMMANDS = (
    ("imu", "read an IMU and publish what it measures", "rosbase.cli.imu"),
    ("demo", "read a simulated IMU over a real link", "rosbase.cli.demo"),
    ("simulate", "run a simulated IMU for you to read", "rosbase.cli.simulate"),
    (_RUNS_PROGRAMS, "run a program, with parameters from outside", "rosbase.cli.run_program"),
    ("up", "start the programs of a file, and stop them together", "rosbase.launcher.command"),
    ("doctor", "find problems on this machine, and say what to do", "rosbase.cli.doctor"),
    ("plugins", "list the installed plugins", "rosbase.cli.list_plugins"),
)


def _command(name: str, summary: str, module: str) -> CommandPlugin:
    def configure(parser: argparse.ArgumentParser) -> None:
        import_module(module).configure(parser)

    def run(arguments: Any) -> int:
        status: int = import_module(module).run(arguments)
        return status

    return CommandPlugin(
        name, summary, configure, run, forwards_backend_arguments=name == _RUNS_PROGRAMS
    )


def _quick_commands() -> Iterable[CommandPlugin]:
    """Return the commands for running programs, which `rosbase.cli.main` runs without plugins.

    They are among the others for `rosbase --help`, and so that no plugin takes their names.
    """
    from rosbase.cli.operate.words import GROUPS

    def configure(parser: argparse.ArgumentParser) -> None:
        parser.add_argument("words", nargs=argparse.REMAINDER)

    def run(arguments: Any) -> int:
        from rosbase.cli.operate import run as run_quickly

        return run_quickly([arguments.command, *arguments.words])

    return [CommandPlugin(name, entry.summary, configure, run) for name, entry in GROUPS.items()]


def _check_python(context: CheckContext) -> Iterable[Finding]:
    from rosbase.cli.core_checks import check_python

    return check_python()


def _check_clock(context: CheckContext) -> Iterable[Finding]:
    from rosbase.cli.core_checks import check_clock

    return check_clock(context.clock)


def _check_plugins(context: CheckContext) -> Iterable[Finding]:
    from rosbase.cli.core_checks import check_plugins

    return check_plugins(installed_plugins())


@hookimpl
def rosbase_commands() -> Iterable[CommandPlugin]:
    """Return the commands of the core."""
    return [*(_command(*command) for command in _COMMANDS), *_quick_commands()]


@hookimpl
def rosbase_checks() -> Iterable[CheckPlugin]:
    """Return the core's own checks."""
    yield CheckPlugin("python", "the interpreter and the platform", _check_python)
    yield CheckPlugin("clock", "the date of this machine", _check_clock)
    yield CheckPlugin("plugins", "the installed plugins, and whether they work", _check_plugins)
