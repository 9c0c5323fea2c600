"""The messages that a program published when it was recorded, in their order."""

import struct
from collections.abc import Generator, Iterable, Iterator

from rosbase_mcap.channel_table import ORIGIN, OUTSIDE
from rosbase_mcap.chunks import MESSAGE_HEAD
from rosbase_mcap.outputs import Output
from rosbase_mcap.reading import read_content
from rosbase_mcap.records import PREFIX, Channel, Kind, Schema
from rosbase_mcap.scanning import records_in

__all__ = ["RecordedOutputs"]

# The head of a message up to its times, in which a replay differs.
_START = struct.Struct("<BQHI")
_HEAD_SIZE, _HEAD_BYTES = MESSAGE_HEAD.size, MESSAGE_HEAD.size - PREFIX.size
# In Python 3.11, to find a member takes 0.2 us.
_MESSAGE = int(Kind.MESSAGE)
_MESSAGE_BYTE = bytes([_MESSAGE])


class RecordedOutputs(Iterator[Output]):
    """Yields the outputs of a run, or steps over those that a replay repeats.

    A repeated output is compared in place, as bytes; no object is created for it.
    """

    def __init__(self, files: Iterable[Iterable[bytes]]) -> None:
        """Begin before the first one.

        Args:
            files: For each file of the run, the records of its chunks, as `chunk_records` yields
                them.
        """
        self.schemas: dict[str, Schema] = {}
        """Schema of each topic so far."""
        self._schemas: dict[int, Schema] = {}
        self._topics: dict[int, str] = {}
        self._channels: dict[str, int] = {}
        self._chunks = self._read(files)
        self._records, self._at = b"", 0

    def close(self) -> None:
        """Close the file that is being read."""
        self._chunks.close()

    def repeats(self, number: int, topic: str, data: bytes) -> bool:
        """Step over the next output if it is this one, and return whether it was.

        It may return False for an equal output. Then `next` returns the output, so that the caller
        can compare it.
        """
        while self._at == len(self._records) and self._open_chunk():
            pass
        channel = self._channels.get(topic)
        if channel is None:
            return False
        at, records = self._at, self._records
        start = _START.pack(_MESSAGE, _HEAD_BYTES + len(data), channel, number)
        if records.startswith(start, at) and records.startswith(data, at + _HEAD_SIZE):
            self._at = at + _HEAD_SIZE + len(data)
            return True
        return False

    def __next__(self) -> Output:
        """Return the next output, and step over it."""
        while True:
            records, at = self._records, self._at
            if at + _HEAD_SIZE <= len(records):
                kind, length, channel, number, log_ns, _ = MESSAGE_HEAD.unpack_from(records, at)
                after = at + PREFIX.size + length
                if kind == _MESSAGE and length >= _HEAD_BYTES and after <= len(records):
                    self._at = after
                    if channel in self._topics:
                        data = records[at + _HEAD_SIZE : after]
                        return Output(number, self._topics[channel], log_ns, data)
                    continue
            if not self._pass_record() and not self._open_chunk():
                raise StopIteration

    def _open_chunk(self) -> bool:
        """Go on with the next chunk, behind the records at its start that are no messages."""
        records = next(self._chunks, None)
        if records is None:
            return False
        self._records, self._at = records, 0
        while records[self._at : self._at + 1] not in (b"", _MESSAGE_BYTE) and self._pass_record():
            pass
        return True

    def _pass_record(self) -> bool:
        """Step over the next record; return False if no whole one is left in the chunk."""
        record = next(records_in(memoryview(self._records)[self._at :]), None)
        if record is None:
            return False
        self._at += PREFIX.size + len(record[1])
        content = read_content(*record)
        if isinstance(content, Schema):
            self._schemas[content.id] = content
        elif isinstance(content, Channel) and content.metadata.get(ORIGIN) != OUTSIDE:
            self._topics[content.id] = content.topic
            self._channels[content.topic] = content.id
            if schema := self._schemas.get(content.schema_id):
                self.schemas.setdefault(content.topic, schema)
        return True

    def _read(self, files: Iterable[Iterable[bytes]]) -> Generator[bytes, None, None]:
        for chunks in files:
            # Each file numbers its own.
            self._schemas, self._topics, self._channels = {}, {}, {}
            yield from chunks
