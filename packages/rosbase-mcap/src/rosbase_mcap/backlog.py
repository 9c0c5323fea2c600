"""Messages on their way from the threads that publish to the thread that writes."""

import os
import threading
from contextlib import suppress
from typing import TypeAlias
from weakref import WeakSet

from rosbase_mcap.chunks import CHUNK_BYTES, MESSAGE_HEAD, OpenChunk

__all__ = ["Backlog"]

_Message: TypeAlias = tuple[int, int, int, int, bytes]

# One is filled while the others are written.
_MOST_SPARE = 4


_backlogs: "WeakSet[Backlog]" = WeakSet()


class Backlog:
    """A queue with a limit in bytes. Any thread adds, one takes all.

    Messages wait as MCAP records, packed into chunks, so the writer has little left to do. One that
    finds no room is dropped and counted: the program never waits for a disk.
    """

    def __init__(self, most_bytes: int) -> None:
        """Begin empty.

        Args:
            most_bytes: Most bytes of records that wait.
        """
        self._most_bytes = most_bytes
        self._chunk_bytes = min(CHUNK_BYTES, most_bytes // 4)
        self._chunk = OpenChunk(self._chunk_bytes)
        # Messages that are longer than a chunk wait as they are.
        self._full: list[OpenChunk | _Message] = []
        self._full_bytes = 0
        # New memory costs more than writing to it.
        self._spare: list[OpenChunk] = []
        # A signal handler may publish while its thread does.
        self._lock = threading.RLock()
        # Free if the writer should come. A signal handler may release a lock at any time; with an
        # Event, it could wait for itself.
        self._wakeup = threading.Lock()
        self._wakeup.acquire()
        self._is_awaited = False
        self.dropped = 0
        """Number of messages that found no room."""
        _backlogs.add(self)

    def add(self, channel: int, sequence: int, log_ns: int, publish_ns: int, data: bytes) -> bool:
        """Add a message; return False if it found no room."""
        with self._lock:
            is_added = self._chunk.add(
                channel, sequence, log_ns, publish_ns, data
            ) or self._add_behind((channel, sequence, log_ns, publish_ns, data))
            if self._is_awaited:
                self._is_awaited = False
                self.wake()
            return is_added

    @property
    def is_wanted(self) -> bool:
        """Whether the writer should come now."""
        return not self._wakeup.locked()

    def take(self) -> list[OpenChunk]:
        """Return what waits, in the order in which it came, and forget it."""
        with self._lock:
            self._end_chunk()
            waiting, self._full, self._full_bytes = self._full, [], 0
            self._wakeup.acquire(blocking=False)
        return [one if isinstance(one, OpenChunk) else _chunk_of(one) for one in waiting]

    def give_back(self, chunk: OpenChunk) -> None:
        """Use the memory of a chunk again, which `take` has returned."""
        if len(self._spare) < _MOST_SPARE and chunk.room_bytes == self._chunk_bytes:
            chunk.clear()
            self._spare.append(chunk)

    def wait(self, timeout_s: float) -> bool:
        """Wait until the writer is wanted; return False if the time is over before.

        It is wanted if `wake` was called, or if the queue is half full.
        """
        return self._wakeup.acquire(timeout=timeout_s)

    def wait_for_next(self, timeout_s: float) -> None:
        """Wait until the next message is added, or the writer is wanted, or the time is over."""
        self._is_awaited = True
        self._wakeup.acquire(timeout=timeout_s)
        self._is_awaited = False

    def wake(self) -> None:
        """End `wait`. Call it from any thread or signal handler."""
        with suppress(RuntimeError):
            # It may be free already.
            self._wakeup.release()

    def forget(self) -> None:
        """Take nothing more. Called in a forked child, where no thread writes."""
        # Another thread of the parent may have held it.
        self._lock = threading.RLock()
        self._most_bytes, self._chunk_bytes, self._chunk = -1, 0, OpenChunk(0)
        self._full, self._full_bytes, self._spare = [], 0, []

    def _add_behind(self, message: _Message) -> bool:
        """Add a message for which the chunk has no room."""
        size = MESSAGE_HEAD.size + len(message[4])
        if self._full_bytes + self._chunk.size_bytes + size > self._most_bytes:
            self.dropped += 1
            self.wake()
            return False
        self._end_chunk()
        # Usually the writer comes by itself.
        if self._full_bytes * 2 > self._most_bytes:
            self.wake()
        if size <= self._chunk_bytes:
            return self.add(*message)
        self._full.append(message)
        self._full_bytes += size
        return True

    def _end_chunk(self) -> None:
        if not self._chunk.size_bytes:
            return
        chunk = self._spare.pop() if self._spare else OpenChunk(self._chunk_bytes)
        # A signal handler that adds a message does so before this line, or behind it.
        chunk, self._chunk = self._chunk, chunk
        self._full.append(chunk)
        self._full_bytes += chunk.size_bytes


def _chunk_of(message: _Message) -> OpenChunk:
    chunk = OpenChunk(MESSAGE_HEAD.size + len(message[4]))
    chunk.add(*message)
    return chunk


def _forget_in_child() -> None:
    for backlog in list(_backlogs):
        backlog.forget()


os.register_at_fork(after_in_child=_forget_in_child)
