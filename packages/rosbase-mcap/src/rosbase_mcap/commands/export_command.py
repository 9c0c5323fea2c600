"""`rosbase export`: write the messages of a recording as tables."""

import argparse
from pathlib import Path
from typing import Any

from rosbase_mcap.commands.chosen import add_selection, selection_of
from rosbase_mcap.commands.opened import opened, say_damage
from rosbase_mcap.csv_export import export_csv
from rosbase_mcap.errors import McapError

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("file", type=Path, metavar="FILE", help="the recording")
    add_selection(parser)
    parser.add_argument("--csv", action="store_true", required=True, help="a CSV file per topic")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help="where to write them; by default, a folder named after the recording",
    )


def run(arguments: Any) -> int:
    """Write a table for each topic."""
    folder: Path = arguments.output or arguments.file.with_suffix("")
    with opened(arguments.file) as stream:
        selection = selection_of(arguments, stream)
        say_damage(arguments.file, stream)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            rows = export_csv(stream, folder, selection)
        except FileExistsError as error:
            raise McapError(f"{error.filename}: there is such a file already") from error
        except OSError as error:
            raise McapError(f"{error.filename or folder}: {error.strerror or error}") from error
    for path, number in rows.items():
        print(f"{path}: {number} rows")
    return 0
