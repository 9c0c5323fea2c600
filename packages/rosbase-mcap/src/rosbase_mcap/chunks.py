"""A chunk that is being filled, and the indexes of one. Pure."""

import struct
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING
from zlib import crc32

from rosbase_mcap.compression import compressed
from rosbase_mcap.records import PREFIX, Chunk, Kind, Message, record
from rosbase_mcap.scanning import records_in

if TYPE_CHECKING:
    from rosbase_mcap.backlog import Item

__all__ = [
    "MESSAGE_HEAD",
    "ChunkBuilder",
    "MessageTimes",
    "contents_of",
    "message_index",
    "message_times",
]

MESSAGE_HEAD = struct.Struct("<BQHIQQ")
"""Record of a message up to its data: kind, length, channel, sequence, log and publish time."""
_HEAD_BYTES = MESSAGE_HEAD.size - PREFIX.size
_MESSAGE = struct.Struct("<HIQ")
# In Python 3.11, to find a member takes 0.2 us.
_KIND_OF_MESSAGE = int(Kind.MESSAGE)

MessageTimes = Mapping[int, Sequence[int]]
"""By channel: `log_ns` and offset of each of its messages, all in one list."""


class ChunkBuilder:
    """Collects messages. Each costs two short lists and no object of its own."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._times: defaultdict[int, list[int]] = defaultdict(list)
        self.size_bytes = 0
        """Length of the records so far."""

    def add(self, channel: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> None:
        """Add a message."""
        self.add_all(((channel, sequence, log_ns, publish_ns, data),))

    def add_all(self, items: "Iterable[Item]") -> None:
        """Add messages, as `add` does, in one call: at high rates, calls are what costs."""
        append, pack = self._parts.append, MESSAGE_HEAD.pack
        times, size = self._times, self.size_bytes
        for channel, sequence, log_ns, publish_ns, data in items:
            length = _HEAD_BYTES + len(data)
            append(pack(_KIND_OF_MESSAGE, length, channel, sequence, log_ns, publish_ns))
            append(data)
            times[channel] += (log_ns, size)
            size += PREFIX.size + length
        self.size_bytes = size

    def take(self, compression: str) -> tuple[Chunk, MessageTimes]:
        """Return the chunk with the times of its messages, and begin another."""
        data, times = b"".join(self._parts), dict(self._times)
        self._parts, self._times, self.size_bytes = [], defaultdict(list), 0
        start_ns, end_ns = _span(times)
        packed = compressed(data, compression)
        return Chunk(start_ns, end_ns, len(data), crc32(data), compression, packed), times


def contents_of(records: bytes | memoryview) -> list[Message | tuple[int, memoryview]]:
    """Return the records of a chunk, in their order: its messages, and kind and content of others.

    What is cut off at the end is left out.
    """
    data, unpack, kind_of_message = bytes(records), MESSAGE_HEAD.unpack_from, _KIND_OF_MESSAGE
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
        if kind == _KIND_OF_MESSAGE and len(content) >= _HEAD_BYTES:
            channel, _, log_ns = _MESSAGE.unpack_from(content)
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
