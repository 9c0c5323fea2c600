"""The primitive types of ROS. Nothing of rosbase is imported: commands start with this module."""

import struct
import sys
from enum import Enum

__all__ = ["TYPECODES", "Width", "is_of"]


class Width(Enum):
    """A primitive type of ROS; the value is its name in a .msg file."""

    BOOL = "bool"
    BYTE = "byte"
    CHAR = "char"
    FLOAT32 = "float32"
    FLOAT64 = "float64"
    INT8 = "int8"
    INT16 = "int16"
    INT32 = "int32"
    INT64 = "int64"
    UINT8 = "uint8"
    UINT16 = "uint16"
    UINT32 = "uint32"
    UINT64 = "uint64"
    STRING = "string"
    WSTRING = "wstring"


TYPECODES = {
    Width.BOOL: "?",
    Width.BYTE: "B",
    Width.CHAR: "B",
    Width.FLOAT32: "f",
    Width.FLOAT64: "d",
    Width.INT8: "b",
    Width.INT16: "h",
    Width.INT32: "i",
    Width.INT64: "q",
    Width.UINT8: "B",
    Width.UINT16: "H",
    Width.UINT32: "I",
    Width.UINT64: "Q",
}
"""Code of each number in `struct`, `array` and `memoryview`."""

# A C long has four bytes on one machine and eight on another, so the size of an element decides.
_SAME_KIND = {"q": ("q", "l"), "Q": ("Q", "L"), "i": ("i", "l"), "I": ("I", "L")}
_THIS_ORDER = "@=<" if sys.byteorder == "little" else "@=>"
_SIZES = {code: struct.calcsize(f"={code}") for code in TYPECODES.values()}


def is_of(view: memoryview, typecode: str) -> bool:
    """Return whether a buffer holds numbers of a typecode, in the byte order of this machine."""
    code = view.format.lstrip(_THIS_ORDER)
    return view.itemsize == _SIZES[typecode] and code in _SAME_KIND.get(typecode, (typecode,))
