"""Writing and reading the parts of a message whose length varies: texts and lists of numbers."""

import functools
import struct
import sys
from array import array
from collections.abc import Callable, Sequence
from typing import Any

from rosbase.errors import WireError
from rosbase.messages.widths import is_of

__all__ = [
    "WIDE_SIZE",
    "UnusualError",
    "packer",
    "put_texts",
    "put_wide_texts",
    "read_numbers",
    "read_text",
    "read_view",
    "read_wide_text",
    "text_of",
    "wide_text_of",
]

_TYPES = {"f": float, "d": float, "?": bool}
_PADDING = (b"", b"\0", b"\0\0", b"\0\0\0")
# Shorter lists have a prepared layout each.
_FEW = 33
WIDE_SIZE = 4
"""Bytes of a unit of a wide text."""
_length = struct.Struct("<I")


class UnusualError(Exception):
    """The fast writer does not take this value, which may be right nevertheless."""


def text_of(text: Any, limit: int) -> bytes:
    """Return a text with the NUL that ends it."""
    data: bytes = text.encode()
    if 0 in data or (limit and len(data) > limit):
        raise UnusualError
    return data + b"\0"


def wide_text_of(text: Any, limit: int) -> bytes:
    """Return a wide text as ROS 2 Jazzy sends it: UTF-16, each unit as a number of four bytes."""
    units: bytes = text.encode("utf-16-le")
    if "\0" in text or (limit and len(units) > 2 * limit):
        raise UnusualError
    data = bytearray(2 * len(units))
    data[0::WIDE_SIZE], data[1::WIDE_SIZE] = units[0::2], units[1::2]
    return bytes(data)


def put_texts(texts: Any, put: Callable[[bytes], object], pos: int, limit: int) -> int:
    """Put texts one behind the other; return where they end."""
    for text in texts:
        pos = _put_text(text_of(text, limit), 1, put, pos)
    return pos


def put_wide_texts(texts: Any, put: Callable[[bytes], object], pos: int, limit: int) -> int:
    """Put wide texts one behind the other; return where they end."""
    for text in texts:
        pos = _put_text(wide_text_of(text, limit), WIDE_SIZE, put, pos)
    return pos


def _put_text(data: bytes, unit: int, put: Callable[[bytes], object], pos: int) -> int:
    padding = -pos & 3
    put(_PADDING[padding] + _length.pack(len(data) // unit) + data)
    return pos + padding + 4 + len(data)


@functools.cache
def packer(code: str) -> Callable[[Any], tuple[Any, int]]:
    """Return the function that packs a list of numbers.

    It returns them as bytes or a view of them, and how many numbers there are.
    """
    is_right = frozenset((_TYPES.get(code, int),)).issuperset
    pack = _packing_of(code)

    def packed(values: Any) -> tuple[Any, int]:
        if type(values) is tuple or type(values) is list:
            if not is_right(map(type, values)):
                raise UnusualError
            return pack(values), len(values)
        if type(values) is bytes and code == "B":
            return values, len(values)
        view = memoryview(values)
        if not (is_of(view, code) and view.c_contiguous):
            raise UnusualError
        # A view of no elements cannot be cast.
        return (view.cast("B") if view.nbytes else b""), view.nbytes // view.itemsize

    return packed


def _packing_of(code: str) -> Callable[[Sequence[Any]], bytes]:
    if code in "B?":
        return bytes
    # Prepared, because struct takes as long to find a layout by its text as to pack.
    few = [struct.Struct(f"<{count}{code}").pack for count in range(_FEW)]

    def packed(values: Sequence[Any]) -> bytes:
        count = len(values)
        if count < _FEW:
            return few[count](*values)
        if code == "f":
            # An array would silently make a number infinite that is too large.
            return struct.pack(f"<{count}f", *values)
        return array(code, values).tobytes()

    return packed


def read_text(data: memoryview, pos: int, size: int, limit: int = 0) -> str:
    """Return the text of that many bytes, the last of which is NUL."""
    if size == 0:
        return ""
    end = pos + size
    if end > len(data) or data[end - 1] != 0:
        raise WireError("a text is cut short, or its length is garbled")
    if limit and size > limit + 1:
        raise WireError(f"a text has {size - 1} bytes, which is more than {limit}")
    text = str(data[pos : end - 1], "utf-8")
    # It could not be written again.
    if "\0" in text:
        raise WireError("a text has a NUL within")
    return text


def read_wide_text(data: memoryview, pos: int, size: int, order: str, limit: int = 0) -> str:
    """Return the text of that many UTF-16 units; whole characters are taken, too."""
    end = pos + WIDE_SIZE * size
    if end > len(data):
        raise WireError("a text is cut short, or its length is garbled")
    units = str(data[pos:end], "utf-32-le" if order == "<" else "utf-32-be", "surrogatepass")
    pairs = units.encode("utf-16-le", "surrogatepass")
    if limit and len(pairs) > 2 * limit:
        raise WireError(f"a text has {len(pairs) // 2} UTF-16 units, which is more than {limit}")
    text = pairs.decode("utf-16-le")
    if "\0" in text:
        raise WireError("a text has a NUL within")
    return text


def read_numbers(data: memoryview, pos: int, count: int, code: str, order: str) -> Sequence[Any]:
    """Return that many numbers as a tuple."""
    form = f"{order}{count}{code}"
    # Compared before anything is allocated: the count may be anything.
    if struct.calcsize(f"={code}") * count > len(data) - pos:
        raise WireError(f"{count} elements are announced, and the message ends before")
    return struct.unpack_from(form, data, pos)


def read_view(data: memoryview, pos: int, count: int, code: str, order: str) -> Any:
    """Return that many numbers as a view of the message."""
    size = struct.calcsize(f"={code}")
    if size * count > len(data) - pos:
        raise WireError(f"{count} elements are announced, and the message ends before")
    # Typed loosely: typeshed wants the code as a literal.
    view: Any = data[pos : pos + size * count]
    if size == 1:
        return view if code == "B" else view.cast(code)
    if (order == "<") is (sys.byteorder == "little"):
        return view.cast(code)
    numbers: array[Any] = array(code, view.tobytes())
    numbers.byteswap()
    swapped_view: Any = memoryview(numbers.tobytes())
    return swapped_view.cast(code)
