"""How MCAP lays out numbers, texts and maps: little-endian, lengths in front. Pure.

Source: https://mcap.dev/spec, "Serialization".
"""

import struct
from collections.abc import Mapping

from rosbase_mcap.errors import McapError

__all__ = ["Cursor", "prefixed", "text", "text_map"]

_U8, _U16, _U32, _U64 = (struct.Struct(f"<{letter}") for letter in "BHIQ")


def text(value: str) -> bytes:
    """Return a text, with its length in bytes in front."""
    return prefixed(value.encode())


def prefixed(data: bytes) -> bytes:
    """Return bytes with their number in front, in 32 bits."""
    return _U32.pack(len(data)) + data


def text_map(values: Mapping[str, str]) -> bytes:
    """Return a map of texts, with its length in bytes in front."""
    return prefixed(b"".join(text(key) + text(value) for key, value in values.items()))


class Cursor:
    """Reads one value after another from the content of a record.

    Every method raises McapError if the bytes end too early.
    """

    def __init__(self, data: bytes | memoryview) -> None:
        self._data = memoryview(data)
        self._at = 0

    @property
    def has_more(self) -> bool:
        """Whether bytes are left."""
        return self._at < len(self._data)

    def u8(self) -> int:
        """Read a number of 8 bits."""
        return self._number(_U8)

    def u16(self) -> int:
        """Read a number of 16 bits."""
        return self._number(_U16)

    def u32(self) -> int:
        """Read a number of 32 bits."""
        return self._number(_U32)

    def u64(self) -> int:
        """Read a number of 64 bits."""
        return self._number(_U64)

    def text(self) -> str:
        """Read a text; bytes that are no UTF-8 are shown as U+FFFD."""
        return str(self.view(self.u32()), "utf-8", "replace")

    def text_map(self) -> dict[str, str]:
        """Read a map of texts."""
        inner = Cursor(self.view(self.u32()))
        found: dict[str, str] = {}
        while inner.has_more:
            key = inner.text()
            found[key] = inner.text()
        return found

    def number_map(self) -> dict[int, int]:
        """Read a map of numbers: of 16 bits to 64."""
        inner = Cursor(self.view(self.u32()))
        found: dict[int, int] = {}
        while inner.has_more:
            key = inner.u16()
            found[key] = inner.u64()
        return found

    def view(self, length: int) -> memoryview:
        """Read that many bytes, without copying them."""
        end = self._at + length
        if end > len(self._data):
            left = len(self._data) - self._at
            raise McapError(f"a record ends too early: {length} bytes expected, {left} left")
        found = self._data[self._at : end]
        self._at = end
        return found

    def rest(self) -> memoryview:
        """Read all bytes that are left, without copying them."""
        return self.view(len(self._data) - self._at)

    def _number(self, kind: struct.Struct) -> int:
        number: int = kind.unpack(self.view(kind.size))[0]
        return number
