"""Files as the commands open and write them."""

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from rosbase_mcap.errors import McapError
from rosbase_mcap.file_writer import Write
from rosbase_mcap.recovery import count_damaged

__all__ = ["damage_text", "opened", "say_damage", "written"]


@contextmanager
def opened(path: Path) -> Iterator[BinaryIO]:
    """Open a recording to read it.

    Raises:
        McapError: It cannot be read; in one line.
    """
    try:
        stream = path.open("rb")
    except IsADirectoryError:
        inner = ", ".join(str(file) for file in sorted(path.glob("*.mcap")))
        instead = f"give a file in it: {inner}" if inner else "no MCAP file is in it"
        raise McapError(f"{path} is a folder: {instead}") from None
    except OSError as error:
        raise McapError(f"{path}: {error.strerror or error}") from error
    with stream:
        yield stream


def damage_text(stream: BinaryIO) -> str:
    """Return how many chunks of a recording are damaged; empty if none are."""
    number = count_damaged(stream)
    return f"{number} damaged chunk{'s' if number > 1 else ''}" if number else ""


def say_damage(path: Path, stream: BinaryIO) -> None:
    """Say in a line on stderr that chunks of a recording are damaged, if some are."""
    if text := damage_text(stream):
        print(f"{path}: {text}: messages are missing", file=sys.stderr)


@contextmanager
def written(path: Path, *, may_replace: bool = False) -> Iterator[Write]:
    """Write a file that has its name only once it is whole.

    Args:
        path: Its name.
        may_replace: Whether there may be a file of that name, which is replaced.

    Raises:
        McapError: It cannot be written; in one line.
    """
    if path.exists() and not may_replace:
        raise McapError(f"{path}: there is such a file already")
    made = ""
    try:
        handle, made = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        with os.fdopen(handle, "wb") as file:
            yield file.write
            file.flush()
            os.fsync(file.fileno())
        # `mkstemp` lets nobody else read it.
        mask = os.umask(0)
        os.umask(mask)
        Path(made).chmod(0o666 & ~mask)
        Path(made).replace(path)
        made = ""
    except OSError as error:
        raise McapError(f"{path}: {error.strerror or error}") from error
    finally:
        if made:
            Path(made).unlink(missing_ok=True)
