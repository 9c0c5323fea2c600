"""Read what is in a file, from its beginning, also of one that was cut off."""

import os
from collections.abc import Callable, Iterator, Sequence
from itertools import takewhile
from typing import Any, BinaryIO, TypeAlias

from attrs import frozen

from rosbase_mcap.chunks import contents_of
from rosbase_mcap.compression import unpacked
from rosbase_mcap.errors import McapError
from rosbase_mcap.records import (
    MAGIC,
    PREFIX,
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Kind,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from rosbase_mcap.recovery import is_complete
from rosbase_mcap.scanning import Found, records_in, records_of
from rosbase_mcap.summary import Summary

__all__ = [
    "Content",
    "Entry",
    "Selection",
    "chunk_records",
    "contents",
    "messages",
    "read_content",
    "read_summary",
]

Content: TypeAlias = Schema | Channel | Message | Attachment | Metadata

_READERS: dict[int, Callable[[bytes | memoryview], Content]] = {
    Kind.SCHEMA: Schema.read,
    Kind.CHANNEL: Channel.read,
    Kind.MESSAGE: Message.read,
    Kind.ATTACHMENT: Attachment.read,
    Kind.METADATA: Metadata.read,
}
_OF_TOPICS = (Kind.SCHEMA, Kind.CHANNEL, Kind.MESSAGE)


@frozen
class Entry:
    """A message with its channel and its schema."""

    channel: Channel
    schema: Schema | None
    message: Message


@frozen
class Selection:
    """Part of a file. The default is all of it."""

    topics: frozenset[str] = frozenset()
    """Full names of the topics; empty for all."""
    start_ns: int | None = None
    """Earliest `log_ns`, in nanoseconds since 1970."""
    end_ns: int | None = None
    """Latest `log_ns`, in nanoseconds since 1970."""

    def has(self, channel: Channel, log_ns: int) -> bool:
        """Return whether a message belongs to it."""
        if self.topics and channel.topic not in self.topics:
            return False
        if self.start_ns is not None and log_ns < self.start_ns:
            return False
        return self.end_ns is None or log_ns <= self.end_ns


def contents(stream: BinaryIO) -> Iterator[Content]:
    """Yield what is in a file, in its order; chunks that are damaged are left out.

    Raises:
        NotMcapError: The file does not begin as an MCAP file does.
    """
    for found in _before_the_end(stream):
        for content in _opened(found):
            if type(content) is Message:
                yield content
            elif (one := read_content(*content)) is not None:
                yield one


def chunk_records(stream: BinaryIO) -> Iterator[bytes]:
    """Yield the records of each chunk as bytes, and each schema, channel or message outside of one.

    Use it to compare messages without creating an object for each. Damaged chunks are left out.

    Raises:
        NotMcapError: The file does not begin as an MCAP file does.
    """
    for found in _before_the_end(stream):
        if found.kind == Kind.CHUNK:
            yield bytes(_unpacked(found))
        elif found.kind in _OF_TOPICS and found.is_whole:
            yield PREFIX.pack(found.kind, len(found.content)) + found.content


def read_content(kind: int, content: bytes | memoryview) -> Content | None:
    """Return what a record holds; None if it is damaged, or of a kind that nobody reads."""
    read = _READERS.get(kind)
    try:
        return read(content) if read is not None else None
    except McapError:
        # Its length was right, so the records behind it are found all the same.
        return None


def messages(stream: BinaryIO, selection: Selection | None = None) -> Iterator[Entry]:
    """Yield the messages of a file, in its order.

    Raises:
        NotMcapError: The file does not begin as an MCAP file does.
    """
    wanted = selection or Selection()
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    for content in contents(stream):
        if isinstance(content, Message):
            channel = channels.get(content.channel_id)
            if channel is not None and wanted.has(channel, content.log_ns):
                yield Entry(channel, schemas.get(channel.schema_id), content)
        elif isinstance(content, Schema):
            schemas[content.id] = content
        elif isinstance(content, Channel):
            channels[content.id] = content


def read_summary(stream: BinaryIO) -> Summary | None:
    """Return the summary of a complete file; None if there is none, or a wrong one."""
    if not is_complete(stream):
        return None
    size = stream.seek(0, os.SEEK_END)
    stream.seek(size - len(MAGIC) - 20)
    footer = Footer.read(stream.read(20))
    # What comes before the footer.
    end = size - len(MAGIC) - 20 - PREFIX.size
    if not len(MAGIC) < footer.summary_at < end:
        return None
    stream.seek(footer.summary_at)
    try:
        return _summary(stream.read(end - footer.summary_at))
    except McapError:
        return None


def _before_the_end(stream: BinaryIO) -> Iterator[Found]:
    """Yield the records of a file up to its summary."""
    return takewhile(lambda one: one.kind not in (Kind.DATA_END, Kind.FOOTER), records_of(stream))


def _opened(found: Found) -> Sequence[Any]:
    """Return a record, or the records in it if it is a chunk; see `contents_of`."""
    if found.kind != Kind.CHUNK:
        return [(found.kind, found.content)] if found.is_whole else []
    return contents_of(_unpacked(found))


def _unpacked(found: Found) -> bytes | memoryview:
    """Return the records of a chunk; none if it is damaged."""
    try:
        chunk = Chunk.read(found.content, is_cut=not found.is_whole)
        if found.is_whole:
            return unpacked(chunk)
    except McapError:
        return b""
    return chunk.data if not chunk.compression else b""


def _summary(data: bytes) -> Summary | None:
    summary = Summary()
    statistics: Statistics | None = None
    for kind, content in records_in(data):
        if kind == Kind.SCHEMA:
            schema = Schema.read(content)
            summary.schemas[schema.id] = schema
        elif kind == Kind.CHANNEL:
            channel = Channel.read(content)
            summary.channels[channel.id] = channel
        elif kind == Kind.STATISTICS:
            statistics = Statistics.read(content)
        elif kind == Kind.CHUNK_INDEX:
            summary.chunks.append(ChunkIndex.read(content))
        elif kind == Kind.ATTACHMENT_INDEX:
            summary.attachments.append(AttachmentIndex.read(content))
        elif kind == Kind.METADATA_INDEX:
            summary.metadata.append(MetadataIndex.read(content))
    if statistics is None:
        return None
    summary.counts.update(statistics.channel_messages)
    if statistics.messages:
        summary.start_ns, summary.end_ns = statistics.start_ns, statistics.end_ns
    return summary
