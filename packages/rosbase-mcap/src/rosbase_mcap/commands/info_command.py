"""`rosbase info`: say what is in a recording."""

import argparse
from pathlib import Path
from typing import Any, BinaryIO

from rosbase_mcap.commands.opened import opened, say_damage
from rosbase_mcap.facts_text import facts_lines
from rosbase_mcap.reading import read_summary
from rosbase_mcap.records import Header, Kind
from rosbase_mcap.recovery import mend
from rosbase_mcap.scanning import records_of

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help="the recording")


def run(arguments: Any) -> int:
    """Print what is in a file, also in one that was cut off."""
    path: Path = arguments.file
    with opened(path) as stream:
        profile = _profile(stream)
        size = stream.seek(0, 2)
        summary = read_summary(stream)
        say_damage(path, stream)
        print(f"file:      {path}")
        if summary is None:
            summary = mend(stream, lambda data: None).summary
            print(f"           it was cut off: `rosbase recover {path}` mends it")
    for line in facts_lines(summary, size_bytes=size, profile=profile):
        print(line)
    return 0


def _profile(stream: BinaryIO) -> str:
    first = next(records_of(stream), None)
    is_header = first is not None and first.is_whole and first.kind == Kind.HEADER
    return Header.read(first.content).profile if first is not None and is_header else ""
