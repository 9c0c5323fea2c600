"""A chunk that is being filled, and the indexes of one. Pure."""

import struct
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from zlib import crc32

from rosbase_mcap.compression import compressed
from rosbase_mcap.records import PREFIX, Chunk, Kind, Message, record
from rosbase_mcap.scanning import records_in

__all__ = [
    "CHUNK_BYTES",
    "MESSAGE_HEAD",
    "MessageTimes",
    "OpenChunk",
    "contents_of",
    "message_index",
    "message_times",
]

# A file with few, long chunks is read quickly; a viewer that jumps to a time reads a whole one.
CHUNK_BYTES = 1 << 20
"""Length of the records of a chunk, unless one message is longer."""
MESSAGE_HEAD = struct.Struct("<BQHIQQ")
"""Record of a message up to its data: kind, length, channel, sequence, log and publish time."""
_HEAD_BYTES = MESSAGE_HEAD.size - PREFIX.size
_MESSAGE_START = struct.Struct("<HIQ")
# In Python 3.11, to find a member takes 0.2 us.
_MESSAGE = int(Kind.MESSAGE)

MessageTimes = Mapping[int, Sequence[int]]
"""By channel: `log_ns` and offset of each of its messages, all in one list."""


class OpenChunk:
    """A chunk that is being filled. Messages are packed into place, and not kept as objects."""

    __slots__ = ("_records", "room_bytes", "size_bytes", "times")

    def __init__(self, room_bytes: int = CHUNK_BYTES) -> None:
        """Begin empty.

        Args:
            room_bytes: Most bytes of records. Memory for so many is reserved.
        """
        self._records = bytearray(room_bytes)
        self.room_bytes = room_bytes
        """Most bytes of records."""
        self.size_bytes = 0
        """Length of the records so far."""
        self.times: defaultdict[int, list[int]] = defaultdict(list)
        """Times and offsets of the messages so far."""

    def add(self, channel: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> bool:
        """Add a message; return False if there is no room for it.

        One thread may call it at a time. A signal handler of that thread may call it meanwhile.
        """
        pack_into, size = _layout(len(data))
        length = size - PREFIX.size
        while True:
            at = self.size_bytes
            if at + size > self.room_bytes:
                return False
            pack_into(
                self._records, at, _MESSAGE, length, channel, sequence, log_ns, publish_ns, data
            )
            # Python runs signal handlers after a call, such as this one. If a handler has added a
            # message, this one goes behind it. Below there is no call.
            if self.size_bytes == at:
                self.size_bytes = at + size
                self.times[channel] += (log_ns, at)
                return True

    @property
    def count(self) -> int:
        """Number of messages so far."""
        return sum(map(len, self.times.values())) // 2

    @property
    def records(self) -> memoryview:
        """The records so far."""
        return memoryview(self._records)[: self.size_bytes]

    def close(self, compression: str) -> Chunk:
        """Return the chunk as it is in a file. If it is not compressed, its data stays here."""
        records = self.records
        packed = compressed(records, compression)
        return Chunk(*_span(self.times), len(records), crc32(records), compression, packed)

    def clear(self) -> None:
        """Forget all messages, and begin another chunk in the same memory."""
        self.size_bytes, self.times = 0, defaultdict(list)


# Not all: pictures of a camera have another length each.
@lru_cache(maxsize=1024)
def _layout(length: int) -> tuple[Callable[..., None], int]:
    """Return the function that packs a message whose data has that length, and its size."""
    layout = struct.Struct(f"{MESSAGE_HEAD.format}{length}s")
    return layout.pack_into, layout.size


def contents_of(records: bytes | memoryview) -> list[Message | tuple[int, memoryview]]:
    """Return the records of a chunk, in their order: its messages, and kind and content of others.

    What is cut off at the end is left out.
    """
    data, unpack, kind_of_message = bytes(records), MESSAGE_HEAD.unpack_from, _MESSAGE
    # In C, as the class itself would do it in Python.
    make = partial(tuple.__new__, Message)
    at, end = 0, len(data)
    found: list[Message | tuple[int, memoryview]] = []
    while at < end:
        # Usually, each is a message: nothing else is done for it than must be.
        if at + MESSAGE_HEAD.size <= end:
            kind, length, channel, sequence, log_ns, publish_ns = unpack(data, at)
            after = at + PREFIX.size + length
            if kind == kind_of_message and length >= _HEAD_BYTES and after <= end:
                content = data[at + MESSAGE_HEAD.size : after]
                found.append(make((channel, sequence, log_ns, publish_ns, content)))
                at = after
                continue
        other = next(records_in(memoryview(data)[at:]), None)
        if other is None:
            break
        found.append(other)
        at += PREFIX.size + len(other[1])
    return found


def message_times(records: bytes | memoryview) -> MessageTimes:
    """Return the times and offsets of the messages among the records of a chunk."""
    times: defaultdict[int, list[int]] = defaultdict(list)
    at = 0
    for kind, content in records_in(records):
        if kind == _MESSAGE and len(content) >= _HEAD_BYTES:
            channel, _, log_ns = _MESSAGE_START.unpack_from(content)
            times[channel] += (log_ns, at)
        at += PREFIX.size + len(content)
    return dict(times)


def message_index(channel: int, times: Sequence[int]) -> bytes:
    """Return the record of the index of one channel."""
    packed = struct.pack(f"<{len(times)}Q", *times)
    return record(Kind.MESSAGE_INDEX, struct.pack("<HI", channel, len(packed)) + packed)


def _span(times: MessageTimes) -> tuple[int, int]:
    if not times:
        return 0, 0
    return min(min(ones[::2]) for ones in times.values()), max(
        max(ones[::2]) for ones in times.values()
    )
