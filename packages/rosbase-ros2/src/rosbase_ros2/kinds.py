"""Checks and conversions of the value of one field of a ROS message.

Only the right kind of value is accepted. rclpy itself checks that only if
`ROS_PYTHON_CHECK_FIELDS` is 1. Otherwise it silently sends an int in a float field, a bool or None
as garbage, and a text only up to its first NUL.
"""

import re
from array import array
from collections.abc import Callable, Iterable, Sequence
from numbers import Integral, Real
from typing import Any, TypeAlias

__all__ = [
    "LIST",
    "TYPECODES",
    "Check",
    "Read",
    "as_float",
    "as_floats",
    "as_int",
    "as_message",
    "as_text",
    "basic_kind",
    "list_check",
    "name_of",
    "numbers_back",
]

Check: TypeAlias = Callable[[Any, str], Any]
"""Function that takes a value and the name of its field; returns the value for the ROS message."""
Read: TypeAlias = Callable[[Any], Any]
"""Function that returns rosbase's value for the value of a ROS field."""

_FLOAT32_MAX = 3.4028234663852886e38
_all_floats = frozenset((float,)).issuperset


def as_float(value: Any, where: str) -> float:
    """Return the number as a float, NaN included.

    Raises:
        TypeError: It is not a number; a bool and a text are not.
        ValueError: It is too large.
    """
    if type(value) is float:
        return value
    # numpy's scalars are numbers here, and a bool would be one too.
    if not isinstance(value, Real) or isinstance(value, bool):
        raise _wrong(value, where, "numbers")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{where} takes numbers that a float can hold") from None


def as_floats(value: Any, where: str) -> Sequence[float]:
    """Return the numbers of a list, a tuple or an array as floats; see `as_float`."""
    values = _as_list(value, where)
    return values if _all_floats(map(type, values)) else [as_float(one, where) for one in values]


def as_int(value: Any, where: str, low: int, high: int) -> int:
    """Return the whole number.

    Raises:
        TypeError: It is not a whole number.
        ValueError: It is out of the range.
    """
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise _wrong(value, where, "whole numbers")
    number = int(value)
    if not low <= number <= high:
        raise ValueError(f"{where} takes whole numbers from {low} to {high}")
    return number


def as_message(value: Any, where: str, kind: type) -> Any:
    """Return the message.

    Raises:
        TypeError: It is of another type.
    """
    if not isinstance(value, kind):
        raise _wrong(value, where, f"messages of type {kind.__name__}")
    return value


def as_text(value: Any, where: str) -> str:
    """Return the text.

    Raises:
        TypeError: It is not a text.
        ValueError: It has a character that ROS cannot send: NUL, or half a surrogate pair.
    """
    if not isinstance(value, str):
        raise _wrong(value, where, "text")
    if "\0" in value or not (value.isascii() or _encodable(value)):
        raise ValueError(f"{where} takes text without NUL and without lone surrogates")
    return value


def _encodable(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _as_float32(value: Any, where: str) -> float:
    number = as_float(value, where)
    # What is infinite or NaN may stay so; only what would silently become infinite may not.
    if _FLOAT32_MAX < abs(number) < float("inf"):
        raise ValueError(f"{where} takes numbers that a 32-bit float can hold")
    return number


def _as_bool(value: Any, where: str) -> bool:
    if not isinstance(value, bool):
        raise _wrong(value, where, "True or False")
    return value


def _as_octet(value: Any, where: str) -> bytes:
    return bytes((as_int(value, where, 0, 255),))


def _as_list(value: Any, where: str) -> Sequence[Any]:
    if isinstance(value, list | tuple | bytes):
        return value
    # numpy's arrays and those of the standard library; a text is no list of texts.
    if isinstance(value, Iterable) and hasattr(value, "tolist"):
        return list(value.tolist())
    raise _wrong(value, where, "a tuple")


def _int_check(bits: int, *, signed: bool) -> Check:
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)

    def check(value: Any, where: str) -> int:
        # The usual case without a second call.
        if type(value) is int and low <= value <= high:
            return value
        return as_int(value, where, low, high)

    return check


def list_check(element: str, each: Check, size: int | None) -> Check:
    """Return the check of a sequence, or of an array of `size`, of elements of a ROS type."""
    typecode = TYPECODES.get(element)
    whole = as_floats if typecode == "d" else None

    def check(value: Any, where: str) -> Any:
        if whole:
            values: Any = whole(value, where)
        else:
            values = [each(one, where) for one in _as_list(value, where)]
        if size is not None and len(values) != size:
            raise ValueError(f"{where} takes {size} elements, not {len(values)}")
        # The setter takes an array as it is; it would look at each element of a list.
        return values if size is not None or not typecode else array(typecode, values)

    return check


def _wrong(value: object, where: str, wanted: str) -> TypeError:
    return TypeError(f"{where} takes {wanted}, not {name_of(type(value))}")


def name_of(kind: type) -> str:
    """Return the name of a class in errors: rosbase and ROS have many of the same name."""
    if kind is type(None):
        return "None"
    if kind.__module__ == "builtins":
        return kind.__name__
    return f"{kind.__module__}.{kind.__name__}"


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
    "boolean": (_as_bool, bool),
    "double": (as_float, float),
    "float": (_as_float32, float),
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
