"""A program that records itself: its topics, its log and its entries, into files or a ring."""

import logging
import os
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

from attrs import field, frozen

from rosbase import Backend, RosbaseLogger
from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.entries import Entry
from rosbase_mcap.file_sink import FileSink
from rosbase_mcap.log_channel import LogChannel
from rosbase_mcap.recorder import Recorder
from rosbase_mcap.ring import Ring
from rosbase_mcap.splitting import Split
from rosbase_mcap.topic_taps import TopicTaps

__all__ = ["ProgramRecording", "RecordingOptions"]


@frozen
class RecordingOptions:
    """What is recorded, and where it goes."""

    path: Path = field(converter=Path)
    """The file; of a ring, the file that is written at the end."""
    topics: frozenset[str] = field(default=frozenset(), converter=frozenset)
    """Full names of the topics; empty for all."""
    last_ns: int | None = None
    """Keep only this time in memory, in nanoseconds, and write it when something has happened."""
    split: Split = field(factory=Split)
    compression: str = ""
    ring_bytes: int = 256 << 20
    """How much a ring keeps at most."""


class ProgramRecording:
    """The recording of one program, from its construction to its end."""

    def __init__(self, backend: Backend, logger: RosbaseLogger, options: RecordingOptions) -> None:
        """Create the file; `start` begins to record.

        Args:
            backend: Connection of the program.
            logger: Says what cannot be recorded.
            options: What is recorded, and where it goes.

        Raises:
            FileExistsError: There is a file of that name; a recording is never overwritten.
            OSError: The file cannot be created.
        """
        self._options = options
        table = ChannelTable()
        self._ring: Ring | None = None
        sink: FileSink | Ring
        facts = _facts(is_whole=options.last_ns is None)
        if options.last_ns is None:
            sink = FileSink(
                options.path,
                table,
                facts,
                split=options.split,
                compression=options.compression,
            )
        else:
            sink = self._ring = Ring(
                table,
                facts,
                keep_ns=options.last_ns,
                most_bytes=options.ring_bytes,
                compression=options.compression,
            )
        self._recorder = Recorder(sink, table, logger, before_flush=self._look_again)
        is_wanted: Callable[[str], bool] = (
            options.topics.__contains__ if options.topics else lambda topic: True
        )
        self._taps = TopicTaps(backend, self._recorder, logger, is_wanted)
        self._log = LogChannel(self._recorder)

    def start(self) -> None:
        """Begin to record."""
        self._taps.look()
        self._recorder.start()

    def log(self, record: logging.LogRecord) -> None:
        """Record what a logger says. Any thread may call it."""
        self._log.take(record)

    def enter(self, entry: Entry) -> None:
        """Record an entry into the program. Any thread may call it, in the order of the numbers."""
        self._recorder.enter(entry)

    def save(self) -> int:
        """Write the ring to its file; return the number of messages. Without a ring, do nothing.

        Raises:
            FileExistsError: It has been written already.
            OSError: The disk takes no more.
        """
        return 0 if self._ring is None else self._ring.save(self._options.path)

    def stop(self) -> None:
        """End the recording in order. May be called repeatedly."""
        self._taps.close()
        self._recorder.stop()

    def _look_again(self) -> None:
        # The taps need the recorder, and come after it.
        self._taps.look()


def _facts(*, is_whole: bool) -> dict[str, str]:
    """Return what a replay must know, beside the entries."""
    return {
        "replays_program": str(is_whole).lower(),
        "rosbase_core": version("rosbase-core"),
        "python": sys.version.split()[0],
        "hash_seed": os.environ.get("PYTHONHASHSEED", "random"),
        "command": " ".join(sys.argv),
    }
