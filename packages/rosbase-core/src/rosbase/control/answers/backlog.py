"""Messages that wait for a client, bounded by their number and by their bytes."""

import threading
from collections import deque
from enum import Enum
from typing import Any
from weakref import WeakSet

__all__ = ["MOST_BYTES", "Backlog", "weight"]

MOST_BYTES = 16 * 1024 * 1024
"""Bytes that all backlogs of this process keep together, beside a message of each."""
# A number, or a message of a few of them.
_OBJECT = 64


class Backlog:
    """The newest messages. Any thread may append; one thread takes.

    Light messages, of which the greatest number fits into the bytes, are only appended.
    """

    def __init__(self, most: int) -> None:
        """Keep at most that many messages."""
        self._most = most
        self._waiting: deque[tuple[int, int, Any]] = deque(maxlen=most)
        # By number, in the order in which they were appended.
        self._heavy: deque[tuple[int, int]] = deque()
        self._heavy_bytes = 0
        self._parts: dict[type, tuple[str, ...]] = {}
        # A handler of a signal may publish while its own thread does.
        self._lock = threading.RLock()
        _backlogs.add(self)

    def __len__(self) -> int:
        return len(self._waiting)

    def append(self, serial: int, stamp_ns: int, message: Any) -> bool:
        """Keep a message; the oldest ones make room for it.

        Returns:
            True when it is filled by half, so that some will soon be lost.
        """
        size, most = weight(message, self._parts), MOST_BYTES // max(1, len(_backlogs))
        if size * self._most <= most:
            self._waiting.append((serial, stamp_ns, message))
            return len(self._waiting) == max(1, self._most // 2)
        with self._lock:
            self._heavy.append((serial, size))
            self._heavy_bytes += size
            self._waiting.append((serial, stamp_ns, message))
            while self._heavy_bytes > most and len(self._waiting) > 1:
                self.take()
            return self._heavy_bytes > most // 2

    def take(self) -> tuple[int, int, Any]:
        """Return the oldest message, with its number and date.

        Raises:
            IndexError: There is none.
        """
        with self._lock:
            oldest = self._waiting.popleft()
            # Lighter ones have pushed some out, too.
            while self._heavy and self._heavy[0][0] <= oldest[0]:
                self._heavy_bytes -= self._heavy.popleft()[1]
            return oldest

    def messages(self) -> list[Any]:
        """Return the messages that wait."""
        return [message for _, _, message in list(self._waiting)]

    def close(self) -> None:
        """Keep nothing, and leave its share of the bytes to others."""
        _backlogs.discard(self)
        with self._lock:
            self._waiting.clear()
            self._heavy.clear()


# A stream that is never closed keeps no share.
_backlogs: WeakSet[Backlog] = WeakSet()


def weight(value: Any, parts: dict[type, tuple[str, ...]]) -> int:
    """Return about how many bytes a message has, from its buffers, texts and sequences.

    Elements of a sequence count as much as its first one.

    Args:
        value: The message, or a part of it.
        parts: By class, the fields that differ in size; this adds to it.
    """
    kind = type(value)
    if kind is bytes or kind is str:
        return len(value)
    if kind is tuple:
        return len(value) * weight(value[0], parts) if value else 0
    names = parts.get(kind)
    if names is None:
        fields = getattr(kind, "__match_args__", ())
        names = tuple(name for name in fields if _varies(getattr(value, name), parts))
        parts[kind] = names
    if not names:
        return int(getattr(value, "nbytes", _OBJECT))
    return _OBJECT + sum([weight(getattr(value, name), parts) for name in names])


def _varies(value: Any, parts: dict[type, tuple[str, ...]]) -> bool:
    """Return whether values of a field may differ in size."""
    if isinstance(value, (bool, int, float, Enum)):
        return False
    weight(value, parts)
    is_message = bool(getattr(type(value), "__match_args__", ()))
    return not is_message or bool(parts.get(type(value)))
