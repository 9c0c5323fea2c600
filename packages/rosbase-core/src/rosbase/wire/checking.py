"""Look at a message that the fast writer does not take: name the fault, or make it usual.

A number of numpy or an int in a float field is right, though unusual. A wrong field is named
with its place, such as `Imu.header.stamp.sec`.
"""

from collections.abc import Callable, Sequence
from numbers import Integral, Real
from types import SimpleNamespace
from typing import Any

from rosbase.messages.widths import Width
from rosbase.wire.structure import Field, Kind, MessageType

__all__ = ["made_usual"]

_FLOAT32_MAX = 3.4028234663852886e38
_BITS = {
    Width.BYTE: (0, 8),
    Width.CHAR: (0, 8),
    **{Width(f"uint{bits}"): (0, bits) for bits in (8, 16, 32, 64)},
    **{Width(f"int{bits}"): (1, bits) for bits in (8, 16, 32, 64)},
}


def made_usual(message: Any, of: MessageType, where: str) -> Any:
    """Return an object with the fields of the message, each of exactly the usual type.

    Raises:
        TypeError: A field has a value of the wrong kind; the text names it.
        ValueError: A value is out of the range of its field; the text names it.
    """
    fields = {one.name: _field(message, one, of, where) for one in of.fields}
    return SimpleNamespace(**fields)


def _field(message: Any, one: Field, of: MessageType, where: str) -> Any:
    try:
        value = getattr(message, one.name)
    except AttributeError:
        raise _wrong(message, where, f"messages of type {of.cls.__name__}") from None
    place = f"{where}.{one.name}"
    if one.kind is Kind.ONE:
        return _element(value, one, place)
    values = _as_list(value, place)
    count = len(values)
    if one.kind is Kind.ARRAY and count != one.size:
        raise ValueError(f"{place} takes {one.size} elements, not {count}")
    if one.kind is Kind.SEQUENCE and one.size and count > one.size:
        raise ValueError(f"{place} takes at most {one.size} elements, not {count}")
    return tuple(_element(element, one, place) for element in values)


def _element(value: Any, of: Field, where: str) -> Any:
    if isinstance(of.element, MessageType):
        return made_usual(value, of.element, where)
    if of.element in _BITS:
        return _as_int(value, where, *_BITS[of.element])
    return _OTHERS[of.element](value, where, of.text_limit)


def _as_int(value: Any, where: str, signed: int, bits: int) -> int:
    if isinstance(value, bytes) and len(value) == 1 and bits == 8 and not signed:
        # As ROS has an octet.
        return value[0]
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise _wrong(value, where, "whole numbers")
    number, low, high = int(value), -signed << (bits - 1), (1 << (bits - signed)) - 1
    if not low <= number <= high:
        raise ValueError(f"{where} takes whole numbers from {low} to {high}")
    return number


def _as_float(value: Any, where: str, _limit: int = 0) -> float:
    # numpy's scalars are numbers here, and a bool would be one too.
    if not isinstance(value, Real) or isinstance(value, bool):
        raise _wrong(value, where, "numbers")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{where} takes numbers that a float can hold") from None


def _as_float32(value: Any, where: str, _limit: int) -> float:
    number = _as_float(value, where)
    # What is infinite or NaN may stay so; only what would silently become infinite may not.
    if _FLOAT32_MAX < abs(number) < float("inf"):
        raise ValueError(f"{where} takes numbers that a 32-bit float can hold")
    return number


def _as_bool(value: Any, where: str, _limit: int) -> bool:
    # numpy's bool is none of Python's.
    if not isinstance(value, bool) and type(value).__name__ not in ("bool", "bool_"):
        raise _wrong(value, where, "True or False")
    return bool(value)


def _as_text(value: Any, where: str, limit: int) -> str:
    text, data = _plain_text(value, where)
    if limit and len(data) > limit:
        raise ValueError(f"{where} takes at most {limit} bytes of text, not {len(data)}")
    return text


def _as_wide_text(value: Any, where: str, limit: int) -> str:
    text, _ = _plain_text(value, where)
    count = len(text.encode("utf-16-le")) // 2
    if limit and count > limit:
        raise ValueError(f"{where} takes at most {limit} UTF-16 units of text, not {count}")
    return text


def _plain_text(value: Any, where: str) -> tuple[str, bytes]:
    if not isinstance(value, str):
        raise _wrong(value, where, "text")
    try:
        data = value.encode()
    except UnicodeEncodeError:
        data = b"\0"
    if 0 in data:
        raise ValueError(f"{where} takes text without NUL and without lone surrogates")
    # `str` would give the name of an enumeration's member, not its text.
    return data.decode(), data


_OTHERS: dict[Width, Callable[[Any, str, int], Any]] = {
    Width.FLOAT64: _as_float,
    Width.FLOAT32: _as_float32,
    Width.BOOL: _as_bool,
    Width.STRING: _as_text,
    Width.WSTRING: _as_wide_text,
}


def _as_list(value: Any, where: str) -> Sequence[Any]:
    if isinstance(value, (list, tuple, bytes)):
        return value
    # numpy's arrays, those of the standard library and memoryviews; a text is no list of texts.
    if hasattr(value, "tolist") and isinstance(elements := value.tolist(), list):
        return elements
    raise _wrong(value, where, "a tuple")


def _wrong(value: object, where: str, wanted: str) -> TypeError:
    return TypeError(f"{where} takes {wanted}, not {_name_of(type(value))}")


def _name_of(kind: type) -> str:
    """Return the name of a class in errors: rosbase and ROS have many of the same name."""
    if kind is type(None):
        return "None"
    if kind.__module__ == "builtins":
        return kind.__name__
    return f"{kind.__module__}.{kind.__name__}"
