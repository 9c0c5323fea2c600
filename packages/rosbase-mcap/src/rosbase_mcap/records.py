"""The records of MCAP, as objects and as bytes. Pure.

A record is its kind in one byte, the length of its content in eight, and the content.
Source: https://mcap.dev/spec, "Records".
"""

import struct
from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple
from zlib import crc32

from attrs import field, frozen

from rosbase_mcap.errors import McapError
from rosbase_mcap.layout import Cursor, prefixed, text, text_map

__all__ = [
    "MAGIC",
    "PREFIX",
    "Attachment",
    "AttachmentIndex",
    "Channel",
    "Chunk",
    "ChunkIndex",
    "Footer",
    "Header",
    "Kind",
    "Message",
    "Metadata",
    "MetadataIndex",
    "Schema",
    "Statistics",
    "record",
]

MAGIC = b"\x89MCAP0\r\n"
"""First and last bytes of a file."""
PREFIX = struct.Struct("<BQ")
"""Head of each record: its kind, and the length of its content."""

_U16, _U32, _U64, _TIMES = (struct.Struct(f"<{form}") for form in ("H", "I", "Q", "QQ"))
_MESSAGE, _COUNTS, _FOOTER = (struct.Struct(f"<{form}") for form in ("HIQQ", "QHIIII", "QQI"))


class Kind(IntEnum):
    """Kinds of records."""

    HEADER = 0x01
    FOOTER = 0x02
    SCHEMA = 0x03
    CHANNEL = 0x04
    MESSAGE = 0x05
    CHUNK = 0x06
    MESSAGE_INDEX = 0x07
    CHUNK_INDEX = 0x08
    ATTACHMENT = 0x09
    ATTACHMENT_INDEX = 0x0A
    STATISTICS = 0x0B
    METADATA = 0x0C
    METADATA_INDEX = 0x0D
    SUMMARY_OFFSET = 0x0E
    DATA_END = 0x0F


def record(kind: Kind, content: bytes) -> bytes:
    """Return a whole record."""
    return PREFIX.pack(kind, len(content)) + content


@frozen
class Header:
    """First record of a file."""

    profile: str
    """Conventions that the file follows, such as `ros2`."""
    library: str
    """Program that has written it."""

    def content(self) -> bytes:
        """Return the content of the record."""
        return text(self.profile) + text(self.library)

    @classmethod
    def read(cls, content: bytes | memoryview) -> "Header":
        """Return the record with that content."""
        cursor = Cursor(content)
        return cls(cursor.text(), cursor.text())


@frozen
class Schema:
    """Type of messages."""

    id: int
    """Number in the file, from 1 up."""
    name: str
    """Name of the type, such as `sensor_msgs/msg/Imu`."""
    encoding: str
    """Format of the schema, such as `ros2msg`."""
    data: bytes
    """The schema."""

    def content(self) -> bytes:
        """Return the content of the record."""
        return _U16.pack(self.id) + text(self.name) + text(self.encoding) + prefixed(self.data)

    @classmethod
    def read(cls, content: bytes | memoryview) -> "Schema":
        """Return the record with that content."""
        cursor = Cursor(content)
        found = cursor.u16(), cursor.text(), cursor.text()
        return cls(*found, bytes(cursor.view(cursor.u32())))


@frozen
class Channel:
    """Topic of a file, with the encoding of its messages."""

    id: int
    """Number in the file."""
    schema_id: int
    """Number of its schema; 0 without one."""
    topic: str
    message_encoding: str
    """Format of the messages, such as `cdr`."""
    metadata: Mapping[str, str] = field(factory=dict)

    def content(self) -> bytes:
        """Return the content of the record."""
        ids = _U16.pack(self.id) + _U16.pack(self.schema_id)
        return ids + text(self.topic) + text(self.message_encoding) + text_map(self.metadata)

    @classmethod
    def read(cls, content: bytes | memoryview) -> "Channel":
        """Return the record with that content."""
        cursor = Cursor(content)
        found = cursor.u16(), cursor.u16(), cursor.text(), cursor.text()
        return cls(*found, cursor.text_map())


class Message(NamedTuple):
    """One message. A tuple, because a file has millions of them."""

    channel_id: int
    sequence: int
    """Number of the message on its channel; 0 if nobody has counted."""
    log_ns: int
    """When it was recorded, in nanoseconds since 1970."""
    publish_ns: int
    """When it was published, in nanoseconds since 1970."""
    data: bytes
    """The message in the encoding of its channel."""

    def content(self) -> bytes:
        """Return the content of the record."""
        numbers = (self.channel_id, self.sequence, self.log_ns, self.publish_ns)
        return _MESSAGE.pack(*numbers) + self.data

    @classmethod
    def read(cls, content: bytes | memoryview) -> "Message":
        """Return the record with that content."""
        # Without a cursor: a file has millions of them.
        if len(content) < _MESSAGE.size:
            raise McapError("a message ends too early")
        channel, sequence, log_ns, publish_ns = _MESSAGE.unpack_from(content)
        return cls(channel, sequence, log_ns, publish_ns, bytes(content[_MESSAGE.size :]))


@frozen
class Chunk:
    """Messages that were written together, perhaps compressed."""

    start_ns: int
    """Earliest `log_ns` of its messages; 0 without any."""
    end_ns: int
    """Latest `log_ns` of its messages; 0 without any."""
    size_bytes: int
    """Length of the records, not compressed."""
    crc: int
    """CRC-32 of the records, not compressed; 0 if unknown."""
    compression: str
    """`lz4`, `zstd`, or empty."""
    data: bytes | memoryview
    """The records, compressed."""

    def content(self) -> bytes:
        """Return the content of the record."""
        return b"".join((self.head(), self.data))

    def head(self) -> bytes:
        """Return the content of the record up to its data."""
        numbers = _TIMES.pack(self.start_ns, self.end_ns) + _U64.pack(self.size_bytes)
        kind = _U32.pack(self.crc) + text(self.compression)
        return numbers + kind + _U64.pack(len(self.data))

    @classmethod
    def read(cls, content: bytes | memoryview, *, is_cut: bool = False) -> "Chunk":
        """Return the record with that content.

        Args:
            content: The content, which the chunk keeps.
            is_cut: Whether the end of the records may be missing.
        """
        cursor = Cursor(content)
        numbers = cursor.u64(), cursor.u64(), cursor.u64(), cursor.u32()
        compression, length = cursor.text(), cursor.u64()
        return cls(*numbers, compression, cursor.rest() if is_cut else cursor.view(length))


@frozen
class ChunkIndex:
    """Where a chunk is, and the indexes of its messages."""

    start_ns: int
    end_ns: int
    offset: int
    """Where its record begins in the file."""
    length: int
    """Length of its record."""
    message_indexes: Mapping[int, int]
    """By channel: where the record of its index begins."""
    message_indexes_length: int
    """Length of all these records."""
    compression: str
    compressed_bytes: int
    size_bytes: int

    def content(self) -> bytes:
        """Return the content of the record."""
        offsets = b"".join(
            _U16.pack(channel) + _U64.pack(offset)
            for channel, offset in self.message_indexes.items()
        )
        return b"".join(
            (
                struct.pack("<QQQQ", self.start_ns, self.end_ns, self.offset, self.length),
                prefixed(offsets),
                _U64.pack(self.message_indexes_length),
                text(self.compression),
                _TIMES.pack(self.compressed_bytes, self.size_bytes),
            )
        )

    @classmethod
    def read(cls, content: bytes | memoryview) -> "ChunkIndex":
        """Return the record with that content."""
        cursor = Cursor(content)
        place = cursor.u64(), cursor.u64(), cursor.u64(), cursor.u64()
        indexes = cursor.number_map(), cursor.u64()
        return cls(*place, *indexes, cursor.text(), cursor.u64(), cursor.u64())


@frozen
class Attachment:
    """A file within the recording."""

    log_ns: int
    create_ns: int
    """When it was made; 0 if unknown."""
    name: str
    media_type: str
    data: bytes

    def content(self) -> bytes:
        """Return the content of the record."""
        names = text(self.name) + text(self.media_type)
        size = _U64.pack(len(self.data))
        whole = _TIMES.pack(self.log_ns, self.create_ns) + names + size + self.data
        return whole + _U32.pack(crc32(whole))

    @classmethod
    def read(cls, content: bytes | memoryview) -> "Attachment":
        """Return the record with that content."""
        cursor = Cursor(content)
        found = cursor.u64(), cursor.u64(), cursor.text(), cursor.text()
        return cls(*found, bytes(cursor.view(cursor.u64())))


@frozen
class AttachmentIndex:
    """Where an attachment is."""

    offset: int
    length: int
    attachment: Attachment
    """The attachment; of one that was read, without its data."""
    size_bytes: int
    """Length of its data."""

    def content(self) -> bytes:
        """Return the content of the record."""
        of = self.attachment
        numbers = (self.offset, self.length, of.log_ns, of.create_ns, self.size_bytes)
        return struct.pack("<QQQQQ", *numbers) + text(of.name) + text(of.media_type)

    @classmethod
    def read(cls, content: bytes | memoryview) -> "AttachmentIndex":
        """Return the record with that content."""
        cursor = Cursor(content)
        offset, length, log_ns, create_ns, size = (cursor.u64() for _ in range(5))
        name, media_type = cursor.text(), cursor.text()
        return cls(offset, length, Attachment(log_ns, create_ns, name, media_type, b""), size)


@frozen
class Metadata:
    """Texts by name."""

    name: str
    values: Mapping[str, str]

    def content(self) -> bytes:
        """Return the content of the record."""
        return text(self.name) + text_map(self.values)

    @classmethod
    def read(cls, content: bytes | memoryview) -> "Metadata":
        """Return the record with that content."""
        cursor = Cursor(content)
        return cls(cursor.text(), cursor.text_map())


@frozen
class MetadataIndex:
    """Where a record of metadata is."""

    offset: int
    length: int
    name: str

    def content(self) -> bytes:
        """Return the content of the record."""
        return _TIMES.pack(self.offset, self.length) + text(self.name)

    @classmethod
    def read(cls, content: bytes | memoryview) -> "MetadataIndex":
        """Return the record with that content."""
        cursor = Cursor(content)
        return cls(cursor.u64(), cursor.u64(), cursor.text())


@frozen
class Statistics:
    """Numbers of what is in a file."""

    messages: int
    schemas: int
    channels: int
    attachments: int
    metadata: int
    chunks: int
    start_ns: int
    """Earliest `log_ns` of all messages; 0 without any."""
    end_ns: int
    """Latest `log_ns` of all messages; 0 without any."""
    channel_messages: Mapping[int, int]
    """Number of messages by channel."""

    def content(self) -> bytes:
        """Return the content of the record."""
        counts = (self.messages, self.schemas, self.channels)
        others = (self.attachments, self.metadata, self.chunks)
        by_channel = b"".join(
            _U16.pack(channel) + _U64.pack(count)
            for channel, count in self.channel_messages.items()
        )
        times = _TIMES.pack(self.start_ns, self.end_ns)
        return _COUNTS.pack(*counts, *others) + times + prefixed(by_channel)

    @classmethod
    def read(cls, content: bytes | memoryview) -> "Statistics":
        """Return the record with that content."""
        cursor = Cursor(content)
        counts = cursor.u64(), cursor.u16(), cursor.u32()
        others = cursor.u32(), cursor.u32(), cursor.u32()
        return cls(*counts, *others, cursor.u64(), cursor.u64(), cursor.number_map())


@frozen
class Footer:
    """Last record of a file."""

    summary_at: int
    """Where the summary begins; 0 without one."""
    offsets_at: int
    """Where the offsets of its groups begin; 0 without any."""
    crc: int
    """CRC-32 from the beginning of the summary to `offsets_at` in the footer; 0 if unknown."""

    def content(self) -> bytes:
        """Return the content of the record."""
        return _FOOTER.pack(self.summary_at, self.offsets_at, self.crc)

    @classmethod
    def read(cls, content: bytes | memoryview) -> "Footer":
        """Return the record with that content."""
        cursor = Cursor(content)
        return cls(cursor.u64(), cursor.u64(), cursor.u32())
