"""Checks and conversions of the value of one field of a ROS message.

Only the right kind of value is accepted. rclpy itself checks that only if
`ROS_PYTHON_CHECK_FIELDS` is 1. Otherwise it silently sends an int in a float field, a bool or None
as garbage, and a text only up to its first NUL.
"""

import re
from array import array
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rosbase.wire.values import (
    as_bool,
    as_float,
    as_float32,
    as_int,
    as_list,
    as_text,
    int_range,
    wrong,
)

__all__ = [
    "LIST",
    "TYPECODES",
    "Check",
    "Read",
    "as_message",
    "basic_kind",
    "list_check",
    "numbers_back",
]

Check: TypeAlias = Callable[[Any, str], Any]
"""Function that takes a value and the name of its field; returns the value for the ROS message."""
Read: TypeAlias = Callable[[Any], Any]
"""Function that returns rosbase's value for the value of a ROS field."""

_all_floats = frozenset((float,)).issuperset


def _as_floats(value: Any, where: str) -> Sequence[float]:
    """Return the numbers of a list, a tuple or an array as floats; see `as_float`."""
    values = as_list(value, where, takes_bytes=False)
    return values if _all_floats(map(type, values)) else [as_float(one, where) for one in values]


def as_message(value: Any, where: str, kind: type) -> Any:
    """Return the message.

    Raises:
        TypeError: It is of another type.
    """
    if not isinstance(value, kind):
        raise wrong(value, where, f"messages of type {kind.__name__}")
    return value


def _as_octet(value: Any, where: str) -> bytes:
    return bytes((as_int(value, where, 0, 255),))


def _int_check(bits: int, *, signed: bool) -> Check:
    low, high = int_range(bits, signed=signed)

    def check(value: Any, where: str) -> int:
        # The usual case without a second call.
        if type(value) is int and low <= value <= high:
            return value
        return as_int(value, where, low, high)

    return check


def list_check(element: str, each: Check, size: int | None) -> Check:
    """Return the check of a sequence, or of an array of `size`, of elements of a ROS type."""
    typecode = TYPECODES.get(element)
    whole = _as_floats if typecode == "d" else None
    takes_bytes = element in ("octet", "uint8")

    def check(value: Any, where: str) -> Any:
        if whole:
            values: Any = whole(value, where)
        else:
            elements = as_list(value, where, takes_bytes=takes_bytes)
            values = [each(one, where) for one in elements]
        if size is not None and len(values) != size:
            raise ValueError(f"{where} takes {size} elements, not {len(values)}")
        # The setter takes an array as it is; it would look at each element of a list.
        return values if size is not None or not typecode else array(typecode, values)

    return check


def numbers_back(values: Any) -> tuple[Any, ...]:
    """Return the numbers of an array as Python's own."""
    return tuple(values.tolist())


# A sequence without a limit, or an array of a fixed size.
LIST = re.compile(r"sequence<(?P<sequence>[\w/]+)>|(?P<array>[\w/]+)\[(?P<size>\d+)\]")

# What ROS keeps in an array of numbers, and Python's typecode for it.
TYPECODES = {
    "double": "d",
    "float": "f",
    **{f"int{bits}": code for bits, code in ((8, "b"), (16, "h"), (32, "i"), (64, "q"))},
    **{f"uint{bits}": code for bits, code in ((8, "B"), (16, "H"), (32, "I"), (64, "Q"))},
}

_BASIC: dict[str, tuple[Check, Read]] = {
    "boolean": (as_bool, bool),
    "double": (as_float, float),
    "float": (as_float32, float),
    "octet": (_as_octet, lambda value: value[0]),
    "string": (as_text, str),
    **{f"int{bits}": (_int_check(bits, signed=True), int) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (_int_check(bits, signed=False), int) for bits in (8, 16, 32, 64)},
}


def basic_kind(ros_kind: str, where: str) -> tuple[Check, Read]:
    """Return the check and the reader of a field of that ROS type.

    Raises:
        TypeError: The type is unknown.
    """
    if ros_kind not in _BASIC:
        raise TypeError(f"{where} is of type {ros_kind} in ROS: it takes a Converter by hand")
    return _BASIC[ros_kind]
