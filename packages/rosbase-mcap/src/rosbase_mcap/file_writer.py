"""Write an MCAP file to a stream, so that at most the chunk that is open is ever lost.

A chunk is written with its indexes, and every other record in one call. Whatever such a file ends
with, `recovery` finds all that is before it.
"""

from collections import deque
from collections.abc import Callable
from importlib.metadata import version
from typing import TypeAlias

from attrs import evolve

from rosbase_mcap.chunks import CHUNK_BYTES, MESSAGE_HEAD, MessageTimes, OpenChunk, message_index
from rosbase_mcap.compression import compressed
from rosbase_mcap.records import (
    MAGIC,
    PREFIX,
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Header,
    Kind,
    Metadata,
    MetadataIndex,
    Schema,
    record,
)
from rosbase_mcap.summary import Snapshot, Summary

__all__ = ["FileWriter", "Write"]

Write: TypeAlias = Callable[[bytes | memoryview], object]
"""Writes all of the bytes, or raises."""

# As many chunks can be given up for the end of a file on a full disk: all of the last second.
_MOST_GIVEN_UP = 2


class FileWriter:
    """Writes one file, from its beginning. One thread uses it."""

    def __init__(
        self,
        write: Write,
        *,
        profile: str = "ros2",
        compression: str = "",
        library: str | None = None,
    ) -> None:
        """Begin the file.

        Args:
            write: Writes all of the bytes, or raises.
            profile: Conventions that the file follows.
            compression: How chunks are compressed; see `compression.COMPRESSIONS`.
            library: Name of the program that writes; by default, of this package.

        Raises:
            McapError: There is no such compression.
        """
        # Not only when a chunk is full: there may be no such compression.
        compressed(b"", compression)
        self._write = write
        self._compression = compression
        self._chunk: OpenChunk | None = None
        self.summary = Summary()
        """Contents of the file so far."""
        self._before: deque[tuple[int, Snapshot]] = deque(maxlen=_MOST_GIVEN_UP)
        self.size_bytes = 0
        """Length of the file so far, without the chunk that is open."""
        library = f"rosbase-mcap {version('rosbase-mcap')}" if library is None else library
        self._put(MAGIC + record(Kind.HEADER, Header(profile, library).content()))

    def declare(self, channel: Channel, schema: Schema | None = None) -> None:
        """Write a channel and its schema, unless the file has them. Do so before its messages.

        They are not in a chunk, so that one that is damaged takes nothing else along.
        """
        if schema is not None:
            self.declare_schema(schema)
        if self.summary.channels.get(channel.id) != channel:
            self._put(record(Kind.CHANNEL, channel.content()))
            self.summary.channels[channel.id] = channel

    def declare_schema(self, schema: Schema) -> None:
        """Write a schema, unless the file has it."""
        if self.summary.schemas.get(schema.id) != schema:
            self._put(record(Kind.SCHEMA, schema.content()))
            self.summary.schemas[schema.id] = schema

    def add(self, channel: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Add a message to the chunk that is open, or to another one if there is no room."""
        message = channel, sequence, log_ns, publish_ns, data
        if self._chunk is None or not self._chunk.add(*message):
            self.end_chunk()
            self._chunk = OpenChunk(max(CHUNK_BYTES, MESSAGE_HEAD.size + len(data)))
            self._chunk.add(*message)

    def end_chunk(self) -> None:
        """Write the chunk that is open, if there is one."""
        if self._chunk is not None:
            chunk, self._chunk = self._chunk, None
            self.add_open(chunk)

    def add_open(self, chunk: OpenChunk) -> None:
        """Write a chunk that was filled elsewhere."""
        self.add_chunk(chunk.close(self._compression), chunk.times)

    def add_chunk(self, chunk: Chunk, times: MessageTimes) -> None:
        """Write a chunk as it is, with the indexes of its messages."""
        self._before.append((self.size_bytes, self.summary.snapshot()))
        head = chunk.head()
        length = PREFIX.size + len(head) + len(chunk.data)
        at = self.size_bytes + length
        indexes, offsets = b"", {}
        for channel, ones in times.items():
            offsets[channel] = at + len(indexes)
            indexes += message_index(channel, ones)
        index = ChunkIndex(
            chunk.start_ns,
            chunk.end_ns,
            self.size_bytes,
            length,
            offsets,
            len(indexes),
            chunk.compression,
            len(chunk.data),
            chunk.size_bytes,
        )
        # The data is long: it is not copied for all to go out in one call.
        try:
            self._write(PREFIX.pack(Kind.CHUNK, length - PREFIX.size) + head)
            self._write(chunk.data)
            self._write(indexes)
        except OSError:
            self._before.pop()
            raise
        # Not before all of it is there.
        self.size_bytes = at + len(indexes)
        self.summary.chunks.append(index)
        self.summary.count(times)

    def attach(self, attachment: Attachment) -> None:
        """Write an attachment."""
        whole = record(Kind.ATTACHMENT, attachment.content())
        place = self.size_bytes, len(whole)
        self._put(whole)
        size = len(attachment.data)
        # Its data would stay in memory.
        named = evolve(attachment, data=b"")
        self.summary.attachments.append(AttachmentIndex(*place, named, size))

    def note(self, metadata: Metadata) -> None:
        """Write metadata."""
        whole = record(Kind.METADATA, metadata.content())
        place = self.size_bytes, len(whole)
        self._put(whole)
        self.summary.metadata.append(MetadataIndex(*place, metadata.name))

    def give_up(self, room_bytes: int) -> bool:
        """Forget the last chunks, as few as free that much; return False if none do.

        `size_bytes` is then the length to which the file must be cut.
        """
        for size_bytes, snapshot in reversed(self._before):
            if self.size_bytes - size_bytes >= room_bytes:
                self.size_bytes = size_bytes
                self.summary.go_back(snapshot)
                self._before.clear()
                return True
        return False

    def finish(self) -> None:
        """Write the chunk that is open, and the end of the file. Call nothing afterwards."""
        self.end_chunk()
        self._put(self.summary.ending(self.size_bytes))

    def _put(self, data: bytes) -> None:
        self._write(data)
        self.size_bytes += len(data)
