"""The description of a message class: its ROS name and its fields, from their annotations."""

import dataclasses
import typing
from collections.abc import Iterator
from typing import Any, ClassVar

import attrs

from rosbase.messages.fields import AtMost, Fixed, Numbers, Width, ros_type
from rosbase.wire.once import once_per_class
from rosbase.wire.structure import Constant, Field, Kind, MessageType

__all__ = ["Constant", "Field", "Kind", "MessageType", "describe"]

_PLAIN = {float: Width.FLOAT64, str: Width.STRING, bool: Width.BOOL}
_NUMBERS = (int, float, bool)


@once_per_class
def describe(cls: type) -> MessageType:
    """Return the description of a message class.

    Raises:
        TypeError: It is none, or a field has no ROS type. The text names class and field.
    """
    name = ros_type(cls)
    if name is None:
        raise TypeError(
            f"{getattr(cls, '__name__', cls)!s} is no message: decorate it with"
            " @message('package/msg/Name')"
        )
    hints = typing.get_type_hints(cls, include_extras=True)
    fields = tuple(
        _field(one.name, alias, hints[one.name], f"{cls.__name__}.{one.name}")._replace(
            is_keyword=bool(one.kw_only), default=_default(one.default)
        )
        for one, alias in _declared(cls)
    )
    return MessageType(name, cls, fields, tuple(_constants(cls, hints)))


def _declared(cls: Any) -> list[tuple[Any, str]]:
    """Return the fields of an attrs class or a dataclass, with their names in the constructor."""
    if attrs.has(cls):
        return [(one, one.alias) for one in attrs.fields(cls) if one.init]
    return [(one, one.name) for one in dataclasses.fields(cls) if one.init]


def _default(value: Any) -> Any:
    """Return the default of a field if a schema can have it: what is not zero or empty."""
    many = value if isinstance(value, tuple) else (value,)
    is_plain = all(
        one.isprintable() if isinstance(one, str) else isinstance(one, (int, float)) for one in many
    )
    return value if is_plain and any(many) else None


def _field(name: str, alias: str, hint: Any, where: str) -> Field:
    base, marks = _taken_apart(hint)
    size = next((mark for mark in marks if isinstance(mark, (Fixed, AtMost))), None)
    for mark in marks:
        if isinstance(mark, Numbers):
            kind = Kind.ARRAY if isinstance(size, Fixed) else Kind.SEQUENCE
            return Field(name, alias, mark.width, kind, size.size if size else 0, is_buffer=True)
    if typing.get_origin(base) is not tuple:
        element, limit = _element(base, marks, where)
        return Field(name, alias, element, text_limit=limit)
    inner = typing.get_args(base)
    element, limit = _element(*_taken_apart(inner[0]), where)
    if len(inner) == 2 and inner[1] is Ellipsis:
        kind = Kind.ARRAY if isinstance(size, Fixed) else Kind.SEQUENCE
        return Field(name, alias, element, kind, size.size if size else 0, limit)
    if len(set(inner)) != 1:
        raise TypeError(f"{where}: an array of ROS has elements of one type")
    return Field(name, alias, element, Kind.ARRAY, len(inner), limit)


def _taken_apart(hint: Any) -> tuple[Any, tuple[Any, ...]]:
    """Return a type without its marks, and the marks; those outside come first."""
    marks: tuple[Any, ...] = ()
    while typing.get_origin(hint) is typing.Annotated:
        marks = (*reversed(hint.__metadata__), *marks)
        hint = hint.__origin__
    return hint, marks


def _element(base: Any, marks: tuple[Any, ...], where: str) -> tuple[Width | MessageType, int]:
    limit = next((mark.size for mark in marks if isinstance(mark, AtMost)), 0)
    for mark in marks:
        if isinstance(mark, Width):
            return mark, limit
    if base in _PLAIN:
        return _PLAIN[base], limit
    if base is int:
        raise TypeError(f"{where}: say how wide the number is, such as Int32 or UInt8")
    if ros_type(base) is not None:
        return describe(base), 0
    raise TypeError(f"{where}: {base!r} is no type of ROS")


def _constants(cls: type, hints: dict[str, Any]) -> Iterator[Constant]:
    for name, hint in hints.items():
        if typing.get_origin(hint) is not ClassVar:
            continue
        base, marks = _taken_apart(typing.get_args(hint)[0])
        width = next((mark for mark in marks if isinstance(mark, Width)), _PLAIN.get(base))
        if width is not None:
            yield Constant(name, width, getattr(cls, name))
