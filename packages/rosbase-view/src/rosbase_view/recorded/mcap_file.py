"""A recording in an MCAP file, as rosbase-mcap reads it. Imported only for a recording."""

import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

from rosbase import ConfigurationError
from rosbase_mcap.compression import unpacked
from rosbase_mcap.errors import McapError
from rosbase_mcap.reading import Selection, messages, read_summary
from rosbase_mcap.records import MAGIC, PREFIX, Chunk, ChunkIndex, Kind, Message
from rosbase_mcap.recovery import mend
from rosbase_mcap.scanning import records_in
from rosbase_mcap.summary import Summary
from rosbase_view.recorded.recording import RecordedMessage, RecordedTopic

__all__ = ["McapFile"]

_ENCODINGS = ("cdr", "ros2msg")


class McapFile:
    """Reads the chunks that are needed; implements `Recording`.

    A file that was cut off is mended in a temporary one.
    """

    def __init__(self, path: Path, on_mend: Callable[[], object] = lambda: None) -> None:
        """Open the file.

        Args:
            path: The file.
            on_mend: Called before a file that was cut off is mended, which takes long if it is big.

        Raises:
            ConfigurationError: It cannot be read, or has no messages that can be shown.
            McapError: It is no MCAP file.
        """
        try:
            self._stream: BinaryIO = path.open("rb")
        except OSError as error:
            raise ConfigurationError(f"{path}: {error.strerror or error}") from error
        try:
            summary = read_summary(self._stream)
            if summary is None:
                self._stream.seek(0)
                if self._stream.read(len(MAGIC)) == MAGIC:
                    on_mend()
                summary = self._mend()
        except BaseException:
            self._stream.close()
            raise
        self.topics, self._names = _topics(summary)
        self.begin_ns, self.end_ns = summary.start_ns or 0, summary.end_ns or 0
        self._chunks = sorted(summary.chunks, key=lambda chunk: (chunk.start_ns, chunk.offset))
        if not self.topics or summary.start_ns is None:
            self._stream.close()
            raise ConfigurationError(f"{path} has no messages of ROS 2 to show")

    def messages(self, from_ns: int) -> Iterator[RecordedMessage]:
        """Yield the messages from a time on, in the order in which they were recorded."""
        if not self._chunks:
            yield from self._unchunked(Selection(start_ns=from_ns))
            return
        for chunk in self._chunks:
            if chunk.end_ns >= from_ns:
                found = [one for one in self._in(chunk) if one.stamp_ns >= from_ns]
                found.sort(key=lambda one: one.stamp_ns)
                yield from found

    def latest(self, before_ns: int) -> Sequence[RecordedMessage]:
        """Return the last message of each topic before a time."""
        found: dict[str, RecordedMessage] = {}
        if not self._chunks:
            _keep_latest(found, self._unchunked(Selection(end_ns=before_ns - 1)))
            return list(found.values())
        missing = {topic.name for topic in self.topics}
        # From the end of a chunk on, nothing later than it can be in one before.
        for chunk in sorted(self._chunks, key=lambda one: one.end_ns, reverse=True):
            if chunk.start_ns >= before_ns or not missing & self._topics_of(chunk):
                continue
            own = (one for one in self._in(chunk) if one.stamp_ns < before_ns)
            _keep_latest(found, (one for one in own if one.topic in missing))
            missing -= found.keys()
        return sorted(found.values(), key=lambda one: one.stamp_ns)

    def close(self) -> None:
        """Close the file. Idempotent."""
        self._stream.close()

    def _mend(self) -> Summary:
        cut = self._stream
        whole = tempfile.TemporaryFile()  # noqa: SIM115 - it is open as long as the recording
        try:
            summary = mend(cut, whole.write).summary
        except BaseException:
            whole.close()
            raise
        self._stream = whole
        cut.close()
        return summary

    def _topics_of(self, chunk: ChunkIndex) -> set[str]:
        if not chunk.message_indexes:
            # Whoever wrote it has not told.
            return set(self._names.values())
        return {self._names[one] for one in chunk.message_indexes if one in self._names}

    def _in(self, chunk: ChunkIndex) -> Iterator[RecordedMessage]:
        """Yield the messages of a chunk; none of a damaged one."""
        self._stream.seek(chunk.offset)
        _, length = PREFIX.unpack(self._stream.read(PREFIX.size))
        try:
            records = unpacked(Chunk.read(self._stream.read(length)))
        except McapError:
            return
        for kind, content in records_in(records):
            if kind == Kind.MESSAGE:
                message = Message.read(content)
                name = self._names.get(message.channel_id)
                if name is not None:
                    yield RecordedMessage(name, message.log_ns, message.data)

    def _unchunked(self, selection: Selection) -> Iterator[RecordedMessage]:
        for entry in messages(self._stream, selection):
            name = self._names.get(entry.channel.id)
            if name is not None:
                yield RecordedMessage(name, entry.message.log_ns, entry.message.data)


def _topics(summary: Summary) -> tuple[Sequence[RecordedTopic], dict[int, str]]:
    """Return the topics that can be shown, and their names by the number of the channel."""
    topics: dict[str, RecordedTopic] = {}
    names: dict[int, str] = {}
    for channel in summary.channels.values():
        schema = summary.schemas.get(channel.schema_id)
        if schema is None or (channel.message_encoding, schema.encoding) != _ENCODINGS:
            continue
        topic = RecordedTopic(channel.topic, schema.name, schema.data.decode(errors="replace"))
        # Several channels may carry a topic, but a topic has one type.
        if topics.setdefault(channel.topic, topic) == topic:
            names[channel.id] = channel.topic
    return list(topics.values()), names


def _keep_latest(found: dict[str, RecordedMessage], messages: Iterable[RecordedMessage]) -> None:
    for one in messages:
        before = found.get(one.topic)
        if before is None or before.stamp_ns <= one.stamp_ns:
            found[one.topic] = one
