"""The last seconds of a program in memory, written only when something has happened."""

import threading
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path

from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.chunks import OpenChunk, contents_of
from rosbase_mcap.file_sink import FACTS, declare
from rosbase_mcap.file_writer import FileWriter
from rosbase_mcap.output_file import OutputFile
from rosbase_mcap.records import Attachment, Message, Metadata

__all__ = ["Ring"]

# Of a topic such as /tf_static, as many old messages are kept as it may have publishers.
_MOST_LATCHED = 1_000
# They say which values and states there are, until others come.
_LASTING = ("/parameter_events", "/transition_event")
_OVERHEAD_BYTES = 200


class Ring:
    """Keeps the messages of the last seconds. One thread adds, any thread saves.

    Messages of latched topics, such as /tf_static, of parameters and of transitions are kept
    longer: without them, the others are hard to read.
    """

    def __init__(
        self,
        table: ChannelTable,
        facts: Mapping[str, str],
        *,
        keep_ns: int,
        most_bytes: int,
        compression: str = "",
    ) -> None:
        """Begin empty.

        Args:
            table: The channels of the messages.
            facts: About the recording.
            keep_ns: For how long messages are kept, in nanoseconds.
            most_bytes: How much is kept at most; the oldest messages go first.
            compression: How chunks of the file are compressed.
        """
        self._table, self._facts = table, facts
        self._keep_ns, self._most_bytes = keep_ns, most_bytes
        self._compression = compression
        self._messages: deque[Message] = deque()
        self._bytes = 0
        self._latched: dict[int, deque[Message]] = {}
        self._lock = threading.Lock()

    def add(self, chunk: OpenChunk) -> None:
        """Take the messages of a chunk, and forget those that are too old."""
        with self._lock:
            for message in contents_of(chunk.records):
                # There is nothing else in it.
                assert isinstance(message, Message)
                self._messages.append(message)
                self._bytes += len(message.data) + _OVERHEAD_BYTES
            if self._messages:
                self._forget(self._messages[-1].log_ns - self._keep_ns)

    def head(self, make: Callable[[int], Metadata]) -> None:
        """Do nothing: a ring has no beginning, so no program can be replayed from it."""

    def attach(self, attachment: Attachment) -> None:
        """Do nothing, as above."""

    def flush(self) -> None:
        """Do nothing: nothing goes to a disk."""

    def note(self, metadata: Metadata) -> None:
        """Do nothing: the facts are written when the ring is."""

    def close(self) -> None:
        """Do nothing, as above."""

    def abandon(self, reason: str) -> None:
        """Do nothing, as above."""

    def save(self, path: Path) -> int:
        """Write what is kept to a file; return the number of messages.

        The ring goes on meanwhile, and keeps what it has.

        Raises:
            FileExistsError: There is a file of that name.
            OSError: The disk takes no more.
        """
        with self._lock:
            old = [message for ones in self._latched.values() for message in ones]
            messages = sorted(old, key=lambda message: message.log_ns) + list(self._messages)
        output = OutputFile(path)
        try:
            writer = FileWriter(output.write, compression=self._compression)
            writer.note(Metadata(FACTS, {**self._facts, "ring": "true"}))
            declare(writer, self._table, {message.channel_id for message in messages})
            for message in messages:
                writer.add(*message)
            writer.finish()
            output.sync()
        finally:
            output.close()
        return len(messages)

    def _is_lasting(self, channel: int) -> bool:
        topic = self._table.channel(channel).topic
        return self._table.is_latched(channel) or topic.endswith(_LASTING)

    def _forget(self, before_ns: int) -> None:
        messages = self._messages
        while messages and (messages[0].log_ns < before_ns or self._bytes > self._most_bytes):
            message = messages.popleft()
            self._bytes -= len(message.data) + _OVERHEAD_BYTES
            if self._is_lasting(message.channel_id):
                kept = self._latched.setdefault(message.channel_id, deque(maxlen=_MOST_LATCHED))
                kept.append(message)
