"""`rosbase cut`: copy a part of a recording."""

import argparse
from pathlib import Path
from typing import Any

from rosbase_mcap.commands.chosen import add_selection, selection_of
from rosbase_mcap.commands.opened import opened, say_damage, written
from rosbase_mcap.compression import COMPRESSIONS
from rosbase_mcap.cutting import cut

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help="the recording")
    add_selection(parser)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="the copy")
    parser.add_argument("--compression", choices=COMPRESSIONS[1:], default="", help="of the copy")


def run(arguments: Any) -> int:
    """Copy a part of a file."""
    with opened(arguments.file) as stream:
        selection = selection_of(arguments, stream)
        say_damage(arguments.file, stream)
        with written(arguments.output) as write:
            number = cut(stream, write, selection, compression=arguments.compression)
    print(f"{arguments.output}: {number} messages")
    return 0
