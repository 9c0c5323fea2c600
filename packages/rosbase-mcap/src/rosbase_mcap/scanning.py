"""Find the records of a file one after another, up to where it was cut off.

Nothing that a file says is believed: a length is compared with the bytes that are left before
anything is read, and of a record that is not whole only what is there is returned.
"""

import os
from collections.abc import Iterator
from os import PathLike
from typing import BinaryIO

from attrs import frozen

from rosbase_mcap.errors import NotMcapError
from rosbase_mcap.records import MAGIC, PREFIX, Kind

__all__ = ["Found", "records_in", "records_of"]


@frozen
class Found:
    """A record of a file."""

    kind: int
    """Its kind; one that `Kind` does not have belongs to a later version of the format."""
    offset: int
    """Where it begins in the file."""
    content: bytes
    is_whole: bool = True
    """False for the last record of a file that was cut off within it."""

    @property
    def end(self) -> int:
        """Where the next record begins."""
        return self.offset + PREFIX.size + len(self.content)


def records_of(stream: BinaryIO) -> Iterator[Found]:
    """Yield the records of a file, up to the footer or to where it was cut off.

    Raises:
        NotMcapError: The file does not begin as an MCAP file does.
    """
    size = stream.seek(0, os.SEEK_END)
    stream.seek(0)
    start = stream.read(len(MAGIC))
    if start != MAGIC:
        name = getattr(stream, "name", None)
        where = f"{name}: " if isinstance(name, (str, PathLike)) else ""
        raise NotMcapError(f"{where}this is no MCAP file")
    at = len(MAGIC)
    while at + PREFIX.size <= size:
        stream.seek(at)
        kind, length = PREFIX.unpack(stream.read(PREFIX.size))
        # Zeros follow where the machine lost power before the data was on the disk.
        if kind == 0:
            return
        left = size - at - PREFIX.size
        found = Found(kind, at, stream.read(min(length, left)), length <= left)
        yield found
        if not found.is_whole or kind == Kind.FOOTER:
            return
        at = found.end


def records_in(data: bytes | memoryview) -> Iterator[tuple[int, memoryview]]:
    """Yield kind and content of the whole records of a chunk; what is cut off at its end is not."""
    view = memoryview(data)
    at = 0
    while at + PREFIX.size <= len(view):
        kind, length = PREFIX.unpack_from(view, at)
        at += PREFIX.size
        if kind == 0 or length > len(view) - at:
            return
        yield kind, view[at : at + length]
        at += length
