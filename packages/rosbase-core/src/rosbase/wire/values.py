"""Check the value of one field of a message, and make it one of Python's usual types.

Each function takes the place of the field for its errors, such as `Imu.header.stamp.sec`. A number
of numpy is right, though unusual.
"""

from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any

__all__ = [
    "as_bool",
    "as_float",
    "as_float32",
    "as_int",
    "as_list",
    "as_text",
    "int_range",
    "name_of",
    "wrong",
]

_FLOAT32_MAX = 3.4028234663852886e38


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
        raise wrong(value, where, "numbers")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{where} takes numbers that a float can hold") from None


def as_float32(value: Any, where: str) -> float:
    """Return the number as a float that fits into 32 bits.

    Raises:
        TypeError: It is not a number.
        ValueError: It is too large.
    """
    number = as_float(value, where)
    # What is infinite or NaN may stay so; only what would silently become infinite may not.
    if _FLOAT32_MAX < abs(number) < float("inf"):
        raise ValueError(f"{where} takes numbers that a 32-bit float can hold")
    return number


def as_int(value: Any, where: str, low: int, high: int) -> int:
    """Return the whole number.

    Raises:
        TypeError: It is not a whole number.
        ValueError: It is out of the range.
    """
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise wrong(value, where, "whole numbers")
    number = int(value)
    if not low <= number <= high:
        raise ValueError(f"{where} takes whole numbers from {low} to {high}")
    return number


def int_range(bits: int, *, signed: bool) -> tuple[int, int]:
    """Return the lowest and the highest whole number of that width."""
    return (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)


def as_bool(value: Any, where: str) -> bool:
    """Return True or False.

    Raises:
        TypeError: It is something else.
    """
    # numpy's bool is none of Python's.
    if not isinstance(value, bool) and type(value).__name__ not in ("bool", "bool_"):
        raise wrong(value, where, "True or False")
    return bool(value)


def as_text(value: Any, where: str) -> str:
    """Return the text.

    Raises:
        TypeError: It is not a text.
        ValueError: It has a character that ROS cannot send: NUL, or half a surrogate pair.
    """
    if not isinstance(value, str):
        raise wrong(value, where, "text")
    try:
        data = value.encode()
    except UnicodeEncodeError:
        data = b"\0"
    if 0 in data:
        raise ValueError(f"{where} takes text without NUL and without lone surrogates")
    # `str` would give the name of an enumeration's member, not its text.
    return data.decode()


def as_list(value: Any, where: str, *, takes_bytes: bool) -> Sequence[Any]:
    """Return the elements of a list, a tuple or an array; of bytes only if they are taken.

    Raises:
        TypeError: It is none of them.
    """
    if isinstance(value, (list, tuple)) or (takes_bytes and isinstance(value, bytes)):
        return value
    # Arrays of numpy and of the standard library, and memoryviews; a text is no list of texts.
    if hasattr(value, "tolist") and isinstance(elements := value.tolist(), list):
        return elements
    raise wrong(value, where, "a tuple")


def wrong(value: object, where: str, wanted: str) -> TypeError:
    """Return the error for a value of the wrong kind."""
    return TypeError(f"{where} takes {wanted}, not {name_of(type(value))}")


def name_of(kind: type) -> str:
    """Return the name of a class in errors: rosbase and ROS have many of the same name."""
    if kind is type(None):
        return "None"
    if kind.__module__ == "builtins":
        return kind.__name__
    return f"{kind.__module__}.{kind.__name__}"
