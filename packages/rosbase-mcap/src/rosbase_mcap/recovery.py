"""Mend a file that was cut off: by SIGKILL, a full disk, or a disk that was pulled out.

The records are found one after another. Every one that is whole is copied as it is, and the indexes
and the end of the file are made anew. Of a chunk that is cut off, the whole messages are kept if it
is not compressed; so no message that is whole in the file is lost. A chunk with a wrong checksum is
left out.
"""

from typing import BinaryIO

from attrs import define, field

from rosbase_mcap.chunks import message_times
from rosbase_mcap.compression import unpacked
from rosbase_mcap.errors import McapError
from rosbase_mcap.file_writer import FileWriter, Write
from rosbase_mcap.records import (
    MAGIC,
    PREFIX,
    Attachment,
    Channel,
    Chunk,
    Header,
    Kind,
    Message,
    Metadata,
    Schema,
)
from rosbase_mcap.scanning import Found, records_in, records_of
from rosbase_mcap.summary import Summary

__all__ = ["Mended", "count_damaged", "is_complete", "mend"]

_FOOTER_BYTES = PREFIX.size + 20


@define
class Mended:
    """Result of mending a file."""

    profile: str = ""
    """Conventions that the file follows."""
    library: str = ""
    """Program that has written it."""
    lost_bytes: int = 0
    """Length of what was behind the last whole record."""
    damaged_chunks: int = 0
    """Number of chunks that were left out."""
    summary: Summary = field(factory=Summary)
    """Contents of the new file."""


def is_complete(stream: BinaryIO) -> bool:
    """Return whether a file has an end, so that readers open it."""
    size = stream.seek(0, 2)
    if size < 2 * len(MAGIC) + _FOOTER_BYTES:
        return False
    stream.seek(size - len(MAGIC) - _FOOTER_BYTES)
    end = stream.read()
    return end.endswith(MAGIC) and end[:1] == bytes((Kind.FOOTER,))


def count_damaged(stream: BinaryIO) -> int:
    """Return the number of damaged parts of a file, whose messages cannot be read.

    It reads the whole file. A part that was cut off at its end does not count.

    Raises:
        NotMcapError: It does not begin as an MCAP file does.
    """
    number, has_end = 0, False
    for found in records_of(stream):
        if found.kind == Kind.CHUNK and found.is_whole:
            number += not _is_sound(found)
        elif found.kind in (Kind.DATA_END, Kind.FOOTER):
            has_end = True
            break
    # Where a length is damaged, nothing behind it is found.
    return number + (is_complete(stream) and not has_end)


def mend(source: BinaryIO, write: Write) -> Mended:
    """Write all that is whole in a file as a complete file.

    Args:
        source: The file; it is only read.
        write: Writes all of the bytes, or raises.

    Raises:
        NotMcapError: It does not begin as an MCAP file does.
    """
    mended = Mended()
    writer: FileWriter | None = None
    end = len(MAGIC)
    for found in records_of(source):
        if writer is None:
            header = _header(found)
            mended.profile, mended.library = header.profile, header.library
            writer = FileWriter(write, profile=header.profile, library=header.library)
            if found.kind == Kind.HEADER:
                end = found.end
                continue
        if found.kind in (Kind.DATA_END, Kind.FOOTER):
            end = found.end
            break
        if _copy(found, writer, mended):
            end = found.end
    if writer is None:
        writer = FileWriter(write)
    writer.finish()
    mended.summary = writer.summary
    if not is_complete(source):
        mended.lost_bytes = source.seek(0, 2) - end
    return mended


def _is_sound(found: Found) -> bool:
    try:
        unpacked(Chunk.read(found.content))
    except McapError:
        return False
    return True


def _header(found: Found) -> Header:
    try:
        return Header.read(found.content) if found.kind == Kind.HEADER else Header("", "")
    except McapError:
        return Header("ros2", "")


def _copy(found: Found, writer: FileWriter, mended: Mended) -> bool:
    """Copy a record; return whether it was whole."""
    if not found.is_whole:
        if found.kind == Kind.CHUNK:
            _salvage(found.content, writer)
        return False
    try:
        _copy_whole(found, writer)
    except McapError:
        # Its length was right, so the records behind it are found all the same.
        mended.damaged_chunks += found.kind == Kind.CHUNK
    return True


def _copy_whole(found: Found, writer: FileWriter) -> None:
    content = found.content
    if found.kind == Kind.CHUNK:
        chunk = Chunk.read(content)
        records = unpacked(chunk)
        _learn(records, writer)
        writer.end_chunk()
        writer.add_chunk(chunk, message_times(records))
    elif found.kind == Kind.ATTACHMENT:
        writer.attach(Attachment.read(content))
    elif found.kind == Kind.METADATA:
        writer.note(Metadata.read(content))
    else:
        _take(found.kind, memoryview(content), writer)


def _learn(records: bytes | memoryview, writer: FileWriter) -> None:
    """Note the schemas and channels in a chunk, which the summary repeats."""
    for kind, content in records_in(records):
        if kind == Kind.SCHEMA:
            schema = Schema.read(content)
            writer.summary.schemas[schema.id] = schema
        elif kind == Kind.CHANNEL:
            channel = Channel.read(content)
            writer.summary.channels[channel.id] = channel


def _take(kind: int, content: memoryview, writer: FileWriter) -> None:
    """Take a record that may be inside a chunk or outside."""
    if kind == Kind.SCHEMA:
        writer.declare_schema(Schema.read(content))
    elif kind == Kind.CHANNEL:
        writer.declare(Channel.read(content))
    elif kind == Kind.MESSAGE:
        message = Message.read(content)
        # A reader could not tell what it is.
        if message.channel_id in writer.summary.channels:
            times = message.log_ns, message.publish_ns
            writer.add(message.channel_id, message.sequence, *times, message.data)


def _salvage(content: bytes, writer: FileWriter) -> None:
    """Take the whole records of a chunk that was cut off."""
    try:
        chunk = Chunk.read(content, is_cut=True)
    except McapError:
        # Not even its head is there.
        return
    if chunk.compression:
        return
    for kind, record in records_in(chunk.data):
        try:
            _take(kind, record, writer)
        except McapError:
            return
