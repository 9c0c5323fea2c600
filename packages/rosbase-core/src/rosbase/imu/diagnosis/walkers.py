"""Walk through bytes as a packed format would, to detect the format. Decodes nothing."""

from collections.abc import Callable

__all__ = ["is_cbor", "is_message_pack", "is_protobuf"]

_MOST_ITEMS = 10_000
_CBOR_BREAK = 0xFF
_FIELD_TYPES = {0, 1, 2, 5}


class _OtherFormatError(Exception):
    """The bytes are not in the format."""


class _Bytes:
    """Bytes that are read from the front, and never beyond their end."""

    def __init__(self, data: bytes) -> None:
        self._data, self._at, self._items = data, 0, 0

    @property
    def left(self) -> int:
        return len(self._data) - self._at

    def take(self, size: int) -> bytes:
        taken = self._data[self._at : self._at + size]
        if len(taken) < size:
            raise _OtherFormatError
        self._at += size
        return taken

    def peek(self) -> int:
        """Return the next byte without taking it."""
        if not self.left:
            raise _OtherFormatError
        return self._data[self._at]

    def number(self, size: int) -> int:
        return int.from_bytes(self.take(size), "big")

    def item(self) -> int:
        """Return the first byte of the next item; the number of items is limited."""
        self._items += 1
        if self._items > _MOST_ITEMS:
            raise _OtherFormatError
        return self.number(1)

    def text(self, size: int) -> None:
        try:
            self.take(size).decode()
        except UnicodeDecodeError:
            raise _OtherFormatError from None


def _fits(data: bytes, walk: Callable[[_Bytes], None]) -> bool:
    rest = _Bytes(data)
    try:
        walk(rest)
    except (_OtherFormatError, RecursionError):
        return False
    return rest.left == 0


def is_cbor(data: bytes) -> bool:
    """Return whether the bytes are one non-empty map or array of CBOR (RFC 8949)."""
    return len(data) > 4 and data[0] >> 5 in (4, 5) and _fits(data, _cbor)


def is_message_pack(data: bytes) -> bool:
    """Return whether the bytes are one non-empty map or array of MessagePack."""
    begins = len(data) > 4 and (0x80 < data[0] <= 0x9F or data[0] in (0xDC, 0xDD, 0xDE, 0xDF))
    return begins and _fits(data, _message_pack)


def is_protobuf(data: bytes) -> bool:
    """Return whether the bytes are fields of protobuf, with plausible numbers, from end to end."""
    return len(data) > 8 and _fits(data, _protobuf)


def _cbor(rest: _Bytes) -> None:
    first = rest.item()
    major, short = first >> 5, first & 0x1F
    if short > 27:
        if short != 31 or major not in (2, 3, 4, 5):
            raise _OtherFormatError
        return _cbor_until_break(rest)
    value = short if short < 24 else rest.number(1 << (short - 24))
    if major == 2:
        rest.take(value)
    elif major == 3:
        rest.text(value)
    elif major in (4, 5):
        for _ in range(value * (major - 3)):
            _cbor(rest)
    elif major == 6:
        _cbor(rest)
    return None


def _cbor_until_break(rest: _Bytes) -> None:
    while rest.peek() != _CBOR_BREAK:
        _cbor(rest)
    rest.take(1)


# By the first byte: how many bytes hold the length, or how many follow.
_PACK_LENGTHS = {
    **{0xC4 + n: (1 << n, "bytes") for n in range(3)},
    **{0xC7 + n: (1 << n, "extension") for n in range(3)},
    **{0xD9 + n: (1 << n, "text") for n in range(3)},
    0xDC: (2, "array"),
    0xDD: (4, "array"),
    0xDE: (2, "map"),
    0xDF: (4, "map"),
}
_PACK_FIXED = {
    **{0xCA: 4, 0xCB: 8},
    **{0xCC + n: 1 << n for n in range(4)},
    **{0xD0 + n: 1 << n for n in range(4)},
    **{0xD4 + n: 1 + (1 << n) for n in range(5)},
}


def _message_pack(rest: _Bytes) -> None:
    first = rest.item()
    if first <= 0x7F or first >= 0xE0 or first in (0xC0, 0xC2, 0xC3):
        return
    if first <= 0x8F:
        _pack_items(rest, 2 * (first & 0x0F))
    elif first <= 0x9F:
        _pack_items(rest, first & 0x0F)
    elif first <= 0xBF:
        rest.text(first & 0x1F)
    elif first in _PACK_FIXED:
        rest.take(_PACK_FIXED[first])
    elif first in _PACK_LENGTHS:
        size, kind = _PACK_LENGTHS[first]
        length = rest.number(size)
        if kind in ("array", "map"):
            _pack_items(rest, length * (2 if kind == "map" else 1))
        elif kind == "text":
            rest.text(length)
        else:
            rest.take(length + (kind == "extension"))
    else:
        raise _OtherFormatError


def _pack_items(rest: _Bytes, number: int) -> None:
    for _ in range(number):
        _message_pack(rest)


def _protobuf(rest: _Bytes) -> None:
    while rest.left:
        key = _varint(rest)
        kind, number = key & 7, key >> 3
        # Fields of messages that people write by hand have small numbers.
        if kind not in _FIELD_TYPES or not 0 < number <= 63:
            raise _OtherFormatError
        if kind == 0:
            _varint(rest)
        else:
            rest.take(_varint(rest) if kind == 2 else 8 if kind == 1 else 4)


def _varint(rest: _Bytes) -> int:
    value = 0
    for shift in range(0, 70, 7):
        byte = rest.item()
        value |= (byte & 0x7F) << shift
        if not byte & 0x80:
            return value
    raise _OtherFormatError
