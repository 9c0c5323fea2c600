"""Entries into a program, in order: ticks, timers, messages and frames. Pure.

A replay needs them. They are no messages of ROS, so they are attachments, one for each time that
the recording was flushed: every reader of MCAP leaves those alone.
"""

import struct
from collections.abc import Iterable, Iterator, Sequence
from enum import IntEnum
from typing import BinaryIO

from attrs import field, frozen

from rosbase_mcap.errors import McapError
from rosbase_mcap.layout import Cursor, prefixed, text
from rosbase_mcap.reading import contents
from rosbase_mcap.records import Attachment

__all__ = ["ENTRIES", "ENTRIES_CHANNEL", "Entry", "EntryKind", "attachment", "entries_of"]

ENTRIES = "rosbase/entries"
"""Name of the attachments."""
ENTRIES_CHANNEL = -1
"""Stands for the number of a channel on the way to the file."""
_MEDIA_TYPE = "application/x-rosbase-entries"
_HEAD = struct.Struct("<QBQ")


class EntryKind(IntEnum):
    """Ways into a program."""

    TICK = 1
    TIMER = 2
    MESSAGE = 3
    """A message from another process."""
    FRAME = 4
    """A frame of a transport."""
    REQUEST = 5
    """A request to a service, or through the control socket."""
    FOREIGN = 6
    """A message that a thread of the user's own has published."""


def _numbers(values: Iterable[int]) -> tuple[int, ...]:
    return tuple(values)


@frozen
class Entry:
    """One entry. It runs as a whole before the next."""

    number: int
    """From 0 up, without a gap."""
    kind: EntryKind
    stamp_ns: int
    """When it came, in nanoseconds since 1970."""
    source: str = ""
    """Name of the timer, the topic, the transport or the service."""
    clock_ns: Sequence[int] = field(default=(), converter=_numbers)
    """Readings of the clock by the entry, in its order, in nanoseconds."""
    data: bytes = b""
    """The message, the frame or the request."""

    def packed(self) -> bytes:
        """Return it as bytes."""
        count = len(self.clock_ns)
        head = _HEAD.pack(self.number, self.kind, self.stamp_ns) + text(self.source)
        return head + struct.pack(f"<I{count}Q", count, *self.clock_ns) + prefixed(self.data)


def attachment(packed: Sequence[bytes], log_ns: int) -> Attachment:
    """Return the attachment with these entries.

    Args:
        packed: The entries as bytes, in their order.
        log_ns: Date of the last one.
    """
    return Attachment(log_ns, 0, ENTRIES, _MEDIA_TYPE, b"".join(packed))


def entries_of(stream: BinaryIO) -> Iterator[Entry]:
    """Yield the entries of a file, in their order.

    Raises:
        NotMcapError: The file does not begin as an MCAP file does.
        McapError: Entries are missing, so nothing behind them can be replayed.
    """
    expected: int | None = None
    for content in contents(stream):
        if not isinstance(content, Attachment) or content.name != ENTRIES:
            continue
        cursor = Cursor(content.data)
        while cursor.has_more:
            entry = _read(cursor)
            if expected is not None and entry.number != expected:
                missing = f"{expected} to {entry.number - 1}"
                raise McapError(f"entries {missing} are missing in the recording")
            expected = entry.number + 1
            yield entry


def _read(cursor: Cursor) -> Entry:
    number, kind, stamp_ns = cursor.u64(), cursor.u8(), cursor.u64()
    try:
        known = EntryKind(kind)
    except ValueError:
        raise McapError(f"an entry is of the unknown kind {kind}") from None
    source = cursor.text()
    clock_ns = [cursor.u64() for _ in range(cursor.u32())]
    return Entry(number, known, stamp_ns, source, clock_ns, bytes(cursor.view(cursor.u32())))
