"""The last seconds of a program in memory, written only when something has happened."""

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from rosbase_mcap.backlog import Item
from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.file_sink import FACTS, write_items
from rosbase_mcap.file_writer import FileWriter
from rosbase_mcap.output_file import OutputFile
from rosbase_mcap.records import Attachment, Metadata

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
        self._items: deque[Item] = deque()
        self._bytes = 0
        self._latched: dict[int, deque[Item]] = {}
        self._lock = threading.Lock()

    def add(self, items: Iterable[Item]) -> None:
        """Take messages, in their order, and forget those that are too old."""
        with self._lock:
            for item in items:
                self._items.append(item)
                self._bytes += len(item[4]) + _OVERHEAD_BYTES
            if self._items:
                self._forget(self._items[-1][2] - self._keep_ns)

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
            old = [item for ones in self._latched.values() for item in ones]
            items = sorted(old, key=lambda item: item[2]) + list(self._items)
        output = OutputFile(path)
        try:
            writer = FileWriter(output.write, compression=self._compression)
            writer.note(Metadata(FACTS, {**self._facts, "ring": "true"}))
            write_items(writer, self._table, items)
            writer.finish()
            output.sync()
        finally:
            output.close()
        return len(items)

    def _is_lasting(self, channel: int) -> bool:
        topic = self._table.channel(channel).topic
        return self._table.is_latched(channel) or topic.endswith(_LASTING)

    def _forget(self, before_ns: int) -> None:
        items = self._items
        while items and (items[0][2] < before_ns or self._bytes > self._most_bytes):
            item = items.popleft()
            self._bytes -= len(item[4]) + _OVERHEAD_BYTES
            if self._is_lasting(item[0]):
                kept = self._latched.setdefault(item[0], deque(maxlen=_MOST_LATCHED))
                kept.append(item)
