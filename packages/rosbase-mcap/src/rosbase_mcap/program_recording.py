"""A program that records itself: its topics, its log and its entries, into files or a ring."""

import os
import sys
import threading
from importlib.metadata import version
from pathlib import Path

from rosbase import Backend, RecordingError, RecordOptions, RosbaseLogger
from rosbase.entries.sink import RecordingSink
from rosbase.logger.observer import add_observer, remove_observer
from rosbase_mcap.channel_table import ChannelTable
from rosbase_mcap.compression import compressed
from rosbase_mcap.file_sink import FileSink
from rosbase_mcap.log_channel import LOG_TOPIC, LogChannel
from rosbase_mcap.recorded_run import RecordedRun
from rosbase_mcap.recorder import Recorder
from rosbase_mcap.ring import Ring
from rosbase_mcap.splitting import Split, free_part
from rosbase_mcap.topic_taps import TopicTaps, wanted

__all__ = ["ProgramRecording"]

_RING_BYTES = 256 << 20


class ProgramRecording:
    """The recording of one program; it implements `rosbase.Recording`."""

    def __init__(self, options: RecordOptions) -> None:
        """Create the file, unless the recording is kept in memory.

        Raises:
            RecordingError: There is a file of that name, or it cannot be created.
        """
        self._options = options
        # Before there is a file.
        compressed(b"", options.compression)
        self._table = ChannelTable()
        facts = _facts(is_whole=options.last_s is None)
        self._ring: Ring | None = None
        self._sink: FileSink | Ring
        if options.last_s is None:
            self._sink = _file_sink(options, self._table, facts)
        else:
            _check_free(options.path)
            self._sink = self._ring = Ring(
                self._table,
                facts,
                keep_ns=int(options.last_s * 1e9),
                most_bytes=_RING_BYTES,
                compression=options.compression,
            )
        self._recorder: Recorder | None = None
        self._run = RecordedRun(options.topics)
        self._is_closed = False
        # `save` may be called by an error and by a user at the same time.
        self._saving = threading.Lock()

    @property
    def entries(self) -> RecordingSink | None:
        """Takes the entries of the program; None if only the last seconds are kept."""
        return None if self._ring is not None else self._run

    def begin(self, backend: Backend, logger: RosbaseLogger) -> None:
        """Begin to record."""
        self._logger = logger
        # The taps need the recorder, and come after it.
        run = self._run if self._run.is_followed else None
        self._recorder = Recorder(
            self._sink, self._table, logger, on_broken=self._stop_hearing, run=run
        )
        self._taps = TopicTaps(backend, self._recorder, logger, wanted(self._options.topics))
        self._taps.begin()
        self._log = LogChannel(self._recorder)
        if wanted(self._options.topics, log=True)(LOG_TOPIC):
            add_observer(self._log.take)
        self._recorder.start()

    def save(self) -> Path | None:
        """Write the ring to a file that is new; return it. Without a ring, do nothing.

        Raises:
            RecordingError: The disk takes no more.
        """
        if self._ring is None or self._recorder is None:
            return None
        self._recorder.drain()
        with self._saving:
            path = free_part(self._options.path)
            try:
                self._ring.save(path)
            except OSError as error:
                raise RecordingError(f"{path}: {error.strerror or error}") from error
            return path

    def close(self, error: BaseException | None) -> None:
        """End the recording in order. If an error has ended the program, write the ring."""
        if self._is_closed:
            return
        self._is_closed = True
        if self._recorder is None:
            self._sink.close()
            return
        self._taps.close()
        remove_observer(self._log.take)
        self._recorder.stop()
        if reason := self._run.spoiled:
            self._logger.warning(f"the recording can be replayed only in part: {reason}")
        if self._ring is None:
            return
        if error is None:
            self._logger.debug("the recording in memory is not written: there was no error")
            return
        try:
            self._logger.info(f"the last seconds of this program are in {self.save()}")
        except RecordingError as fault:
            self._logger.error(f"the last seconds of this program are lost: {fault}")

    def _stop_hearing(self) -> None:
        # The program need not pay for it any more.
        self._taps.close()


def _file_sink(options: RecordOptions, table: ChannelTable, facts: dict[str, str]) -> FileSink:
    split = Split(options.split_bytes, int(options.split_s * 1e9))
    try:
        return FileSink(options.path, table, facts, split=split, compression=options.compression)
    except FileExistsError:
        raise _exists(options.path) from None
    except OSError as error:
        raise RecordingError(f"{options.path}: {error.strerror or error}") from error


def _check_free(path: Path) -> None:
    # Later it would be too late to choose another name.
    if path.exists():
        raise _exists(path)
    if not path.absolute().parent.is_dir():
        raise RecordingError(f"{path}: there is no such folder")


def _exists(path: Path) -> RecordingError:
    return RecordingError(f"{path}: there is such a file already, and it is not overwritten")


def _facts(*, is_whole: bool) -> dict[str, str]:
    """Return what a replay must know, beside the entries."""
    return {
        "replays_program": str(is_whole).lower(),
        "rosbase_core": version("rosbase-core"),
        "python": sys.version.split()[0],
        "hash_seed": os.environ.get("PYTHONHASHSEED", "random"),
        "command": " ".join(sys.argv),
    }
