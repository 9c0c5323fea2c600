"""Register the command `rosbase view`. Imports no terminal library."""

import argparse
from collections.abc import Iterable
from typing import Any

from rosbase import CommandPlugin, hookimpl

__all__ = ["rosbase_commands"]


def _configure(parser: argparse.ArgumentParser) -> None:
    from rosbase_view.command import configure

    configure(parser)


def _run(arguments: Any) -> int:
    from rosbase_view.command import run

    return run(arguments)


@hookimpl
def rosbase_commands() -> Iterable[CommandPlugin]:
    """Register the views."""
    yield CommandPlugin("view", "see running programs, or a recording", _configure, _run)
