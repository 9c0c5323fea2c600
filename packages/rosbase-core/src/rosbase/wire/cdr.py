"""The layout of CDR, little-endian, as DDS sends messages.

Sources: OMG DDS-RTPS 2.3, section 10 (the four bytes in front), and CORBA 3.3, part 2, section 9.3:
a number stands at a multiple of its own size, counted after those four. A text has its length in
front, with the NUL that ends it; a sequence has its number of elements in front.
"""

import struct
from collections.abc import Sequence
from typing import NamedTuple

from rosbase.messages.widths import TYPECODES
from rosbase.wire.structure import Field, Kind, MessageType

__all__ = ["HEADER", "ORDERS", "SIZES", "Run", "least_size", "least_size_of_element"]

HEADER = b"\x00\x01\x00\x00"
"""The four bytes in front of a little-endian message."""
ORDERS = {b"\x00\x01": "<", b"\x00\x00": ">"}
"""The byte order by the first two bytes of a message."""
SIZES = {width: struct.calcsize(f"<{code}") for width, code in TYPECODES.items()}
"""Number of bytes of each number."""
_ALIGNMENTS = 8


def least_size(of: Field) -> int:
    """Return a lower bound of the bytes that a field takes."""
    if of.kind is Kind.SEQUENCE:
        return 4
    return least_size_of_element(of) * (of.size if of.kind is Kind.ARRAY else 1)


def least_size_of_element(of: Field) -> int:
    """Return a lower bound of the bytes that one element of a field takes; at least 1."""
    if isinstance(of.element, MessageType):
        return max(1, sum(map(least_size, of.element.fields)))
    return SIZES.get(of.element, 4)


class Run(NamedTuple):
    """Numbers that stand one behind the other, and the padding between them.

    The padding depends on where the run begins, so there are eight layouts.
    """

    codes: Sequence[str]
    """Codes of the numbers. `9d` is an array of nine doubles, already packed as bytes, and `9s` a
    text of nine bytes."""

    def layouts(self, order: str = "<") -> "list[struct.Struct]":
        """Return the layouts, by the offset of the begin within eight bytes."""
        return [struct.Struct(order + self._padded(offset)) for offset in range(_ALIGNMENTS)]

    def whole(self, order: str = "<") -> struct.Struct:
        """Return the layout of a message that consists of the run, with the four bytes in front."""
        return struct.Struct(f"{order}{len(HEADER)}s{self._padded(0)}")

    def _padded(self, offset: int) -> str:
        parts: list[str] = []
        for code in self.codes:
            size = struct.calcsize(f"<{code}")
            padding = -offset % struct.calcsize(f"<{code[-1]}")
            parts.append("x" * padding + (code if len(code) == 1 else f"{size}s"))
            offset += padding + size
        return "".join(parts)
