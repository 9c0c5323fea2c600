"""The files of a recorded run: its trace, and what it has published."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from attrs import evolve, frozen

from rosbase.entries.trace import TraceBlock
from rosbase_mcap.commands.opened import damage_text, opened
from rosbase_mcap.errors import McapError
from rosbase_mcap.reading import chunk_records, contents, read_summary
from rosbase_mcap.recorder import LOSSES
from rosbase_mcap.records import PREFIX, Attachment, Channel, Metadata, Schema
from rosbase_mcap.recovery import is_complete
from rosbase_mcap.replaying.recorded_outputs import RecordedOutputs
from rosbase_mcap.splitting import part_path
from rosbase_mcap.traces import (
    BROKEN,
    END,
    RUN,
    Run,
    RunEnd,
    blocks_of,
    is_trace,
    read_end,
    read_run,
)

__all__ = ["RunFile", "open_run"]

# If so many files of a recording are missing at a place, the ones behind are not found.
_MOST_MISSING = 10


class RunFile:
    """A recorded run, in one file or several. Files that were cut off are read as they are."""

    def __init__(
        self, run: Run, paths: list[Path], end: RunEnd | None, lost: int, no_end: str = ""
    ) -> None:
        self.run = run
        """Facts of the run."""
        self.paths = paths
        """Its files, in their order."""
        self.end = end
        """Facts of its end; None for a run that was killed."""
        self.no_end = no_end
        """Why the end is missing, in one line; empty if it is there."""
        self.lost = lost
        """How many messages are missing, because the disk was too slow or full."""

    def blocks(self) -> Iterator[TraceBlock]:
        """Yield the blocks of the trace, up to the first that is missing or damaged."""
        yield from blocks_of(self._attachments())

    def check_undamaged(self) -> None:
        """Check that all messages can be read; it reads all files.

        Raises:
            McapError: Some cannot.
        """
        for path in self.paths:
            with opened(path) as stream:
                if text := damage_text(stream):
                    raise McapError(f"{path} cannot be compared: {text}")

    def outputs(self) -> RecordedOutputs:
        """Return what the program has published, in its order."""
        return RecordedOutputs(map(_chunks, self.paths))

    def _attachments(self) -> Iterator[Attachment]:
        for path in self.paths:
            with opened(path) as stream:
                yield from _traces(stream)


def open_run(path: Path) -> RunFile | None:
    """Return the run that a file has recorded; None if it is a recording without a trace.

    Args:
        path: Its first file, or its only one.

    Raises:
        NotMcapError: It is no recording.
        McapError: It cannot be read, is not the first file, or is of a later format.
    """
    first = _part(path)
    if first.run is None:
        return None
    if first.run.part:
        raise McapError(f"{path} is file {first.run.part + 1} of a recording: give the first one")
    parts = [first]
    while parts[-1].end is None:
        following = part_path(path, len(parts))
        found = _part(following) if following.exists() else None
        # The file may be of another recording that is named like a part of this one.
        if found is None or found.run != evolve(first.run, part=len(parts)):
            break
        parts.append(found)
    paths = [part.path for part in parts]
    lost = sum(part.lost for part in parts)
    return RunFile(first.run, paths, parts[-1].end, lost, _no_end(path, first.run, parts))


def _no_end(path: Path, run: Run, parts: "list[_Part]") -> str:
    """Return why the end of a recording is missing; empty if it is there."""
    last, following = parts[-1], part_path(path, len(parts))
    if last.end is not None:
        return ""
    if last.broken:
        why = last.broken
    elif not last.is_complete:
        why = "its program was killed, or the disk was full"
    elif _goes_on_after(path, run, len(parts)):
        why = f"{following.name} is missing"
    else:
        why = f"its program was killed, the disk was full, or {following.name} is missing"
    return f"the recording has no end: {why}"


def _goes_on_after(path: Path, run: Run, missing: int) -> bool:
    """Return whether there are later files of a recording than the one that is missing."""
    numbers = range(missing + 1, missing + 1 + _MOST_MISSING)
    later = [(number, part_path(path, number)) for number in numbers]
    return any(_part(one).run == evolve(run, part=n) for n, one in later if one.exists())


@frozen
class _Part:
    path: Path
    run: Run | None
    end: RunEnd | None
    lost: int
    is_complete: bool = True
    """Whether readers open it."""
    broken: str = ""
    """Why it ends before its program; empty if it does not say so."""


def _part(path: Path) -> _Part:
    """Return what a file says of its run."""
    end: RunEnd | None = None
    lost, broken = 0, ""
    with opened(path) as stream:
        run = _run(stream)
        for metadata in _ending(stream):
            if metadata.name == END:
                end = read_end(metadata)
            elif metadata.name == BROKEN:
                broken = metadata.values.get("reason", "")
            else:
                with suppress(KeyError, ValueError):
                    lost += int(metadata.values["messages"])
        return _Part(path, run, end, lost, is_complete(stream), broken)


def _run(stream: BinaryIO) -> Run | None:
    """Return what the start of a file says: before its first message."""
    for content in contents(stream):
        if isinstance(content, Metadata) and content.name == RUN:
            return read_run(content)
        if not isinstance(content, (Metadata, Schema, Channel)):
            return None
    return None


def _ending(stream: BinaryIO) -> Iterator[Metadata]:
    """Yield the metadata of a file that is whole; what was cut off has none of its end."""
    summary = read_summary(stream)
    for index in summary.metadata if summary else ():
        if index.name in (END, LOSSES, BROKEN):
            stream.seek(index.offset + PREFIX.size)
            yield Metadata.read(stream.read(index.length - PREFIX.size))


def _chunks(path: Path) -> Iterator[bytes]:
    with opened(path) as stream:
        yield from chunk_records(stream)


def _traces(stream: BinaryIO) -> Iterator[Attachment]:
    summary = read_summary(stream)
    if summary is None:
        yield from (one for one in contents(stream) if isinstance(one, Attachment))
        return
    for index in summary.attachments:
        if is_trace(index.attachment):
            stream.seek(index.offset + PREFIX.size)
            yield Attachment.read(stream.read(index.length - PREFIX.size))
