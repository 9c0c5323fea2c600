"""Messages on their way from the threads that publish to the thread that writes."""

import os
import threading
from typing import TypeAlias
from weakref import WeakSet

__all__ = ["Backlog", "Item"]

Item: TypeAlias = tuple[int, int, int, int, bytes]
"""Channel, sequence, `log_ns`, `publish_ns` and data of a message."""

# What a message costs in memory beside its data: a tuple, its numbers, the head of `bytes`.
_OVERHEAD_BYTES = 200


_backlogs: "WeakSet[Backlog]" = WeakSet()


class Backlog:
    """A queue with a limit in bytes. Any thread adds, one takes all.

    A message that finds no room is dropped and counted: the program never waits for a disk.
    """

    def __init__(self, most_bytes: int) -> None:
        """Begin empty.

        Args:
            most_bytes: How much waits at most, with what it costs beside its data.
        """
        self._most_bytes = most_bytes
        self._items: list[Item] = []
        self._bytes = 0
        # A signal handler may publish while its thread does.
        self._lock = threading.RLock()
        self._is_wanted = threading.Event()
        self.dropped = 0
        """Number of messages that found no room."""
        _backlogs.add(self)

    def add(self, item: Item) -> bool:
        """Add a message; return False if it found no room."""
        size = len(item[4]) + _OVERHEAD_BYTES
        with self._lock:
            waiting = self._bytes + size
            is_added = waiting <= self._most_bytes
            if is_added:
                self._items.append(item)
                self._bytes = waiting
            else:
                self.dropped += 1
        # Usually the writer comes by itself: to wake it for each message would cost more than
        # the message.
        if waiting * 2 > self._most_bytes and not self.is_wanted:
            self._is_wanted.set()
        return is_added

    @property
    def is_wanted(self) -> bool:
        """Whether the writer should come now."""
        return self._is_wanted.is_set()

    def take(self) -> list[Item]:
        """Return what waits, in the order in which it came, and forget it."""
        with self._lock:
            items, self._items, self._bytes = self._items, [], 0
            self._is_wanted.clear()
        return items

    def wait(self, timeout_s: float) -> None:
        """Wait until `wake` was called, or the queue is half full, or the time is over."""
        self._is_wanted.wait(timeout_s)

    def wake(self) -> None:
        """End `wait`. Call it from any thread."""
        self._is_wanted.set()

    def forget(self) -> None:
        """Take nothing more. Called in a forked child, where no thread writes."""
        # Another thread of the parent may have held it.
        self._lock = threading.RLock()
        self._most_bytes, self._items, self._bytes = -1, [], 0


def _forget_in_child() -> None:
    for backlog in list(_backlogs):
        backlog.forget()


os.register_at_fork(after_in_child=_forget_in_child)
