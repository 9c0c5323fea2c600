"""Look at a message that the fast writer does not take: name the fault, or make it usual.

A number of numpy or an int in a float field is right, though unusual. A wrong field is named
with its place, such as `Imu.header.stamp.sec`.
"""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from rosbase.messages.widths import Width
from rosbase.wire.structure import Field, Kind, MessageType
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

__all__ = ["made_usual"]

_OCTET = int_range(8, signed=False)
_OCTETS = (Width.BYTE, Width.CHAR, Width.UINT8)
_RANGES = {
    Width.BYTE: _OCTET,
    Width.CHAR: _OCTET,
    **{Width(f"uint{bits}"): int_range(bits, signed=False) for bits in (8, 16, 32, 64)},
    **{Width(f"int{bits}"): int_range(bits, signed=True) for bits in (8, 16, 32, 64)},
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
        raise wrong(message, where, f"messages of type {of.cls.__name__}") from None
    place = f"{where}.{one.name}"
    if one.kind is Kind.ONE:
        return _element(value, one, place)
    values = as_list(value, place, takes_bytes=one.element in _OCTETS)
    count = len(values)
    if one.kind is Kind.ARRAY and count != one.size:
        raise ValueError(f"{place} takes {one.size} elements, not {count}")
    if one.kind is Kind.SEQUENCE and one.size and count > one.size:
        raise ValueError(f"{place} takes at most {one.size} elements, not {count}")
    return tuple(_element(element, one, place) for element in values)


def _element(value: Any, of: Field, where: str) -> Any:
    if isinstance(of.element, MessageType):
        return made_usual(value, of.element, where)
    if of.element in _RANGES:
        return _as_int(value, where, of.element)
    if of.element in _TEXTS:
        return _TEXTS[of.element](value, where, of.text_limit)
    return _OTHERS[of.element](value, where)


def _as_int(value: Any, where: str, of: Width) -> int:
    low, high = _RANGES[of]
    if isinstance(value, bytes) and len(value) == 1 and (low, high) == _OCTET:
        # As ROS has an octet.
        return value[0]
    return as_int(value, where, low, high)


def _as_text(value: Any, where: str, limit: int) -> str:
    text = as_text(value, where)
    if limit and (count := len(text.encode())) > limit:
        raise ValueError(f"{where} takes at most {limit} bytes of text, not {count}")
    return text


def _as_wide_text(value: Any, where: str, limit: int) -> str:
    text = as_text(value, where)
    if limit and (count := len(text.encode("utf-16-le")) // 2) > limit:
        raise ValueError(f"{where} takes at most {limit} UTF-16 units of text, not {count}")
    return text


_OTHERS: dict[Width, Callable[[Any, str], Any]] = {
    Width.FLOAT64: as_float,
    Width.FLOAT32: as_float32,
    Width.BOOL: as_bool,
}
_TEXTS: dict[Width, Callable[[Any, str, int], str]] = {
    Width.STRING: _as_text,
    Width.WSTRING: _as_wide_text,
}
