"""Messages into files, one after another. One thread uses it."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.chunks import OpenChunk
from rosbase_mcap.file_writer import FileWriter
from rosbase_mcap.output_file import OutputFile
from rosbase_mcap.records import Attachment, Metadata
from rosbase_mcap.splitting import Split, part_path
from rosbase_mcap.traces import BROKEN

__all__ = ["FACTS", "FileSink", "declare"]

FACTS = "rosbase"
"""Name of the metadata with the facts of a recording."""
# Disks have room in blocks.
_SLACK_BYTES = 8_192


def declare(writer: FileWriter, table: ChannelTable, channels: Iterable[int]) -> None:
    """Write the channels that are new to a file."""
    for number in sorted(set(channels) - writer.summary.channels.keys()):
        writer.declare(table.channel(number), table.schema(number))


class FileSink:
    """Writes a recording to disk.

    Every method raises OSError if the disk takes no more; then `abandon` saves what is there.
    """

    def __init__(
        self,
        path: Path,
        table: ChannelTable,
        facts: Mapping[str, str],
        *,
        split: Split | None = None,
        compression: str = "",
    ) -> None:
        """Create the first file.

        Args:
            path: Its name, from which the names of further files are made.
            table: The channels of the messages.
            facts: About the recording; each file has them.
            split: When the next file begins.
            compression: How chunks are compressed.

        Raises:
            FileExistsError: There is a file of that name.
        """
        self._path, self._table, self._facts = path, table, facts
        self._split = split or Split()
        self._compression = compression
        self._part = 0
        self._head: Callable[[int], Metadata] | None = None
        self._synced = 0
        self._begin()

    @property
    def path(self) -> Path:
        """The file that is written now."""
        return self._output.path

    def head(self, make: Callable[[int], Metadata]) -> None:
        """Write metadata at the start of each file; call it before the first message.

        Args:
            make: Returns the metadata for the file of that number, from 0 up.
        """
        self._head = make
        self._writer.note(make(self._part))

    def add(self, chunk: OpenChunk) -> None:
        """Write a chunk."""
        declare(self._writer, self._table, chunk.times)
        self._writer.add_open(chunk)

    def attach(self, attachment: Attachment) -> None:
        """Write an attachment."""
        self._writer.attach(attachment)

    def flush(self) -> None:
        """Put everything on the disk; begin another file if this one is full."""
        if self._writer.size_bytes == self._synced:
            return
        self._output.sync()
        self._synced = self._writer.size_bytes
        summary = self._writer.summary
        duration_ns = (summary.end_ns or 0) - (summary.start_ns or 0)
        if self._split.is_due(self._writer.size_bytes, duration_ns):
            self.close()
            self._part += 1
            self._begin()

    def note(self, metadata: Metadata) -> None:
        """Write metadata to the file that is written now."""
        self._writer.note(metadata)

    def close(self) -> None:
        """End the file."""
        self._writer.finish()
        self._output.sync()
        self._output.close()

    def abandon(self, reason: str) -> None:
        """End the file as well as can be. Raises nothing: what it leaves can be mended.

        Args:
            reason: Why, for those who read the file.
        """
        if self._output.is_closed:
            # It was complete, and there was no room for the next one.
            return
        _quietly(self._cut)
        # There may be room for the end although there was none for a chunk. If not, a chunk goes.
        if not _quietly(lambda: self._write_end(reason)):
            self._writer.give_up(len(self._ending()) + _SLACK_BYTES)
            _quietly(self._cut)
            if not _quietly(lambda: self._write_end(reason)):
                _quietly(self._cut)
        _quietly(self._output.close)

    def _cut(self) -> None:
        self._output.cut(self._writer.size_bytes)

    def _write_end(self, reason: str) -> None:
        self._writer.note(Metadata(BROKEN, {"reason": reason}))
        self._output.write(self._ending())

    def _ending(self) -> bytes:
        return self._writer.summary.ending(self._writer.size_bytes)

    def _begin(self) -> None:
        self._output = OutputFile(part_path(self._path, self._part))
        self._writer = FileWriter(self._output.write, compression=self._compression)
        self._synced = 0
        self._writer.note(Metadata(FACTS, {**self._facts, "part": str(self._part)}))
        if self._head is not None:
            self._writer.note(self._head(self._part))


def _quietly(function: Callable[[], object]) -> bool:
    """Call a function; return whether the disk has allowed it."""
    try:
        function()
    except OSError:
        return False
    return True
