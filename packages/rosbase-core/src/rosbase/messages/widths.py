"""The primitive types of ROS. Nothing else is imported here: commands start with this module."""

from enum import Enum

__all__ = ["TYPECODES", "Width"]


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
