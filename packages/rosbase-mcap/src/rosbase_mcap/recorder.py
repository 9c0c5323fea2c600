"""The thread that writes a recording, and the way of messages to it."""

import threading
from collections.abc import Callable, Mapping
from itertools import count
from threading import get_ident
from typing import Protocol

from rosbase import RosbaseLogger, SystemClock, background_thread
from rosbase_mcap.backlog import Backlog
from rosbase_mcap.channel_table import ORIGIN, OUTSIDE, ChannelTable
from rosbase_mcap.chunks import OpenChunk
from rosbase_mcap.errors import McapError
from rosbase_mcap.recorded_run import RecordedRun
from rosbase_mcap.records import Attachment, Metadata

__all__ = ["LOSSES", "Recorder", "Sink"]

LOSSES = "rosbase_dropped"
"""Name of the metadata that a file has at its end if messages were dropped."""
# A kill loses at most the time between two looks at the queue: the sum of these.
_FLUSH_S = 0.5
_GRACE_S = 0.1
_JOIN_S = 10.0
# A thread of Python that works delays others by up to 5 ms, `sys.getswitchinterval`. So it lets go
# of Python's lock between two chunks, for long enough that the main loop gets it.
_PAUSE_S = 0.0002
_CLOCK = SystemClock()
_BACKLOG_BYTES = 64 << 20
_MASK = 0xFFFFFFFF


class Sink(Protocol):
    """Where a recording goes. One thread uses it; OSError means that it takes no more."""

    def add(self, chunk: OpenChunk) -> None:
        """Take the messages of a chunk, which is used again afterwards."""
        ...

    def head(self, make: Callable[[int], Metadata]) -> None:
        """Write metadata at the start of each file, made for its number."""
        ...

    def attach(self, attachment: Attachment) -> None:
        """Take an attachment, behind the messages that were taken."""
        ...

    def flush(self) -> None:
        """Bring to safety what was taken."""
        ...

    def note(self, metadata: Metadata) -> None:
        """Take metadata."""
        ...

    def close(self) -> None:
        """End in order."""
        ...

    def abandon(self, reason: str) -> None:
        """End as well as can be, after an OSError, and note the reason. Raises nothing."""
        ...


class Recorder:
    """Takes messages on any thread, and writes them on its own.

    A disk that takes no more ends the recording with one line in the log, not the program.
    """

    def __init__(
        self,
        sink: Sink,
        table: ChannelTable,
        logger: RosbaseLogger,
        *,
        on_broken: Callable[[], object] = lambda: None,
        run: RecordedRun | None = None,
        most_bytes: int = _BACKLOG_BYTES,
    ) -> None:
        """Prepare; `start` begins to write.

        Args:
            sink: Where the messages go.
            table: The channels.
            logger: Says what was lost.
            on_broken: Called when the disk takes no more, on the thread that writes. It must not
                raise.
            run: The entries of the program, if they are recorded too.
            most_bytes: How much may wait for the disk.
        """
        self._sink, self._table, self._logger = sink, table, logger
        self._on_broken = on_broken
        self._run = run
        self._backlog = Backlog(most_bytes)
        self._thread = background_thread(self._work, "recorder")
        # Held from the moment that messages are taken until they are in the sink.
        self._writing = threading.Lock()
        self._is_stopping = False
        self._is_broken = False
        self._unwritten = 0
        self.written = 0
        """Number of messages that the sink has taken."""
        self._said = 0

    @property
    def dropped(self) -> int:
        """Number of messages that are missing, because the disk was too slow or full."""
        return self._backlog.dropped + self._unwritten

    @property
    def is_broken(self) -> bool:
        """Whether the disk took no more."""
        return self._is_broken

    def channel(
        self, topic: str, type_name: str, schema: str, metadata: Mapping[str, str]
    ) -> Callable[[int, int, bytes], object]:
        """Return the function that records a message: `record(log_ns, publish_ns, data)`.

        See `Channels`. If entries are recorded, the messages of each are numbered with it, and
        those that come from outside of the program have a channel of their own.
        """
        number = self._table.add(topic, type_name, schema, metadata)
        sequence = count().__next__
        add, run = self._backlog.add, self._run
        outside: int | None = None

        def record(log_ns: int, publish_ns: int, data: bytes) -> object:
            nonlocal outside
            if log_ns < 0 or publish_ns < 0:
                # MCAP has no dates before 1970.
                log_ns, publish_ns = max(log_ns, 0), max(publish_ns, 0)
            if run is None:
                return add(number, sequence() & _MASK, log_ns, publish_ns, data)
            if run.turn.owner == get_ident():
                return add(number, run.trace.number & _MASK, log_ns, publish_ns, data)
            if outside is None:
                own = {**metadata, ORIGIN: OUTSIDE}
                outside = self._table.add(topic, type_name, schema, own)
            return add(outside, sequence() & _MASK, log_ns, publish_ns, data)

        return record

    def drain(self) -> None:
        """Bring to the sink now what waits. Call it from any thread."""
        with self._writing:
            # The trace first: all messages of its entries are there, except the last entry's,
            # which may be running.
            block = self._run.take() if self._run is not None else None
            self._write(self._backlog.take(), block)

    def start(self) -> None:
        """Begin to write."""
        if self._run is not None:
            self._sink.head(self._run.head)
        self._thread.start()

    def stop(self) -> None:
        """Write what waits, end the file, and end the thread. May be called repeatedly."""
        if self._is_stopping:
            return
        self._is_stopping = True
        if self._thread.ident is None:
            # It was never started, and there is a file to end.
            self.drain()
            self._end()
            return
        self._backlog.wake()
        self._thread.join(_JOIN_S)
        if self._thread.is_alive():
            self._logger.error("the recording does not end: its disk does not answer")

    def _work(self) -> None:
        while True:
            if not self._backlog.wait(_FLUSH_S):
                # Most programs publish in ticks. Right after a message, the next tick is as far
                # away as it gets, so it need not wait for Python's lock.
                self._backlog.wait_for_next(_GRACE_S)
            # Before the messages are taken, so that the last ones are among them.
            is_last = self._is_stopping
            self.drain()
            self._say_losses()
            if is_last:
                self._end()
                return

    def _write(self, chunks: list[OpenChunk], block: Attachment | None) -> None:
        if self._is_broken:
            self._unwritten += sum(chunk.count for chunk in chunks)
            return
        try:
            for chunk in chunks:
                self._sink.add(chunk)
                self.written += chunk.count
                if not self._is_stopping:
                    _CLOCK.sleep(_PAUSE_S)
            if block is not None:
                self._sink.attach(block)
            self._sink.flush()
        except Exception as error:
            # Any: what waits must go, or it would fill the memory.
            self._break(error)
            self._unwritten += sum(chunk.count for chunk in chunks)
            return
        for chunk in chunks:
            self._backlog.give_back(chunk)

    def _end(self) -> None:
        if self._is_broken:
            return
        try:
            if self.dropped:
                self._sink.note(Metadata(LOSSES, {"messages": str(self.dropped)}))
            if self._run is not None:
                self._sink.note(self._run.end())
            self._sink.close()
        except Exception as error:
            self._break(error)

    def _break(self, error: Exception) -> None:
        self._is_broken = True
        self._sink.abandon(str(error))
        # A disk explains itself; anything else is a mistake of ours.
        traceback = None if isinstance(error, (OSError, McapError)) else error
        self._logger.error(
            f"the recording ends here, the program goes on: {error}", exc_info=traceback
        )
        self._on_broken()

    def _say_losses(self) -> None:
        # Each time that it has doubled: a few lines, however long it goes on.
        if not self._is_broken and self.dropped >= max(1, 2 * self._said):
            self._said = self.dropped
            self._logger.warning(
                f"{self._said} messages are missing in the recording so far: the disk is too slow"
            )
