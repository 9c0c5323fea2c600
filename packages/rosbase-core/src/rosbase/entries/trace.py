"""The trace of a run: its entries as whole numbers, and the payloads that belong to them.

The holder of the turn notes; the thread of a writer takes what is there, in blocks. Neither waits
for the other.
"""

import struct
import sys
import zlib
from array import array
from collections.abc import Iterator

from attrs import frozen

from rosbase.entries.kinds import INTS, IS_NOTE
from rosbase.entries.payloads import Payload, as_bytes

__all__ = ["Trace", "TraceBlock"]

_MAGIC = b"RBTR"
_FORMAT = 1
_ZLIB = 1
_HEADER = struct.Struct("<4sBBHQqIII")
_LEVEL = 1


@frozen
class TraceBlock:
    """Entries that were noted one after the other, with their notes.

    Its first notes may belong to the last entry of the block before. Its last payloads may belong
    to the next one.
    """

    first_entry: int
    """Number of the first entry that begins in the block."""
    ints: tuple[int, ...]
    """Kinds, each with its numbers."""
    payloads: tuple[Payload, ...]
    """Payloads, in the order of the kinds that have one."""

    @property
    def starts(self) -> Iterator[int]:
        """The place in `ints` of each entry that begins in the block."""
        ints, sizes, notes = self.ints, INTS, IS_NOTE
        place, end = 0, len(self.ints)
        while place < end:
            kind = ints[place]
            if kind not in notes:
                yield place
            place += 1 + sizes[kind]

    @property
    def start_ns(self) -> int:
        """The time at which the first entry of the block began, since the start of the run."""
        first = next(self.starts, None)
        return 0 if first is None else self.ints[first + 1]

    def to_bytes(self, start_date_ns: int = 0) -> bytes:
        """Return the block as it is in a file.

        Args:
            start_date_ns: The date at which the run started. The header has the date of the first
                entry of the block, for readers that look for one.
        """
        payloads = [as_bytes(payload) for payload in self.payloads]
        lengths = array("I", [len(payload) for payload in payloads])
        body = zlib.compress(
            b"".join([_little(array("q", self.ints)), _little(lengths), *payloads]), _LEVEL
        )
        header = _HEADER.pack(
            _MAGIC,
            _FORMAT,
            _ZLIB,
            0,
            self.first_entry,
            start_date_ns + self.start_ns,
            len(self.ints),
            len(payloads),
            len(body),
        )
        return header + body

    @classmethod
    def from_bytes(cls, data: bytes) -> "TraceBlock":
        """Return the block of some bytes that `to_bytes` made.

        Raises:
            ValueError: They are damaged, or from a later version of rosbase.
        """
        try:
            magic, version, packing, _, first, _, ints, payloads, length = _HEADER.unpack_from(data)
            if (magic, version, packing) != (_MAGIC, _FORMAT, _ZLIB):
                raise ValueError("these bytes are no trace of a format that rosbase knows")
            body = memoryview(zlib.decompress(data[_HEADER.size : _HEADER.size + length]))
        except (struct.error, zlib.error) as error:
            raise ValueError(f"the trace is damaged: {error}") from error
        head, at = 8 * ints, 8 * ints + 4 * payloads
        lengths = _native(array("I"), body[head:at])
        if len(lengths) != payloads or at + sum(lengths) != len(body):
            raise ValueError("the trace is damaged: its lengths contradict each other")
        cut = []
        for size in lengths:
            cut.append(bytes(body[at : at + size]))
            at += size
        return cls(first, tuple(_native(array("q"), body[:head])), tuple(cut))


class Trace:
    """Where the holder of the turn notes entries."""

    __slots__ = ("_next_entry", "ints", "number", "payloads")

    def __init__(self) -> None:
        self.ints: list[int] = []
        """Notes that nobody has taken yet: kinds, each with its numbers."""
        self.payloads: list[Payload] = []
        """Their payloads."""
        self.number = -1
        """Number of the entry that began last."""
        self._next_entry = 0

    def begin(self, kind: int, *numbers: int, payload: Payload | None = None) -> None:
        """Note the beginning of an entry."""
        self.number += 1
        if payload is not None:
            self.payloads.append(payload)
        self.ints.extend((kind, *numbers))

    def note(self, kind: int, *numbers: int, payload: Payload | None = None) -> None:
        """Note something that belongs to the entry that began last."""
        # The payload first: whoever takes the numbers finds it.
        if payload is not None:
            self.payloads.append(payload)
        self.ints.extend((kind, *numbers))

    def take(self) -> TraceBlock:
        """Return what was noted since the last call. Only one thread may call it."""
        # Each note is one step of Python, and so is each of these.
        count = len(self.ints)
        ints = tuple(self.ints[:count])
        del self.ints[:count]
        count = len(self.payloads)
        payloads = tuple(self.payloads[:count])
        del self.payloads[:count]
        block = TraceBlock(self._next_entry, ints, payloads)
        self._next_entry += sum(1 for _ in block.starts)
        return block


def _little(numbers: "array[int]") -> bytes:
    if sys.byteorder == "big":
        numbers.byteswap()
    return numbers.tobytes()


def _native(numbers: "array[int]", data: memoryview) -> "array[int]":
    numbers.frombytes(data)
    if sys.byteorder == "big":
        numbers.byteswap()
    return numbers
