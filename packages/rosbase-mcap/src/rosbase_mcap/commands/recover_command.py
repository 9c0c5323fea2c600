"""`rosbase recover`: mend a recording that was cut off."""

import argparse
from pathlib import Path
from typing import Any

from rosbase_mcap.commands.opened import opened, written
from rosbase_mcap.recovery import is_complete, mend

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help="the recording")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="where to write it; by default, in place"
    )


def run(arguments: Any) -> int:
    """Mend a file, and say what came of it."""
    source, target = arguments.file, arguments.output or arguments.file
    with opened(source) as stream:
        if is_complete(stream) and arguments.output is None:
            print(f"{source}: nothing to mend")
            return 0
        with written(target, may_replace=arguments.output is None) as write:
            mended = mend(stream, write)
    print(f"{target}: {mended.summary.messages} messages, {mended.lost_bytes} bytes cut off")
    if mended.damaged_chunks:
        print(f"{target}: {mended.damaged_chunks} damaged chunks were left out")
    return 0
