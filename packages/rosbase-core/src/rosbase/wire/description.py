"""The description of a message class: its ROS name and its fields, from their annotations."""

import typing
from collections.abc import Iterator
from contextvars import ContextVar
from enum import Enum
from typing import Any, ClassVar

import attrs
from attrs import field, frozen

from rosbase.messages.fields import AtMost, Fixed, Numbers, Width, ros_type
from rosbase.wire.once import once_per_class

__all__ = ["Constant", "Field", "Kind", "MessageType", "describe"]

_PLAIN = {float: Width.FLOAT64, str: Width.STRING, bool: Width.BOOL}
# The classes that are being described, each a part of the one before.
_under_way: ContextVar[tuple[type, ...]] = ContextVar("under_way", default=())


class Kind(Enum):
    """How many elements a field has."""

    ONE = "one"
    ARRAY = "array"
    SEQUENCE = "sequence"


@frozen
class Field:
    """One field of a message."""

    name: str
    alias: str
    """Name of its argument in the constructor."""
    element: "Width | MessageType"
    """Type of the field, or of its elements."""
    kind: Kind = Kind.ONE
    size: int = 0
    """Number of elements of an array, or the most of a bounded sequence; 0: any number."""
    text_limit: int = 0
    """Most bytes of a text; 0: any number."""
    is_buffer: bool = False
    """Whether its numbers are a buffer."""
    is_keyword: bool = False
    """Whether the constructor takes it by name only."""


@frozen
class Constant:
    """One constant of a message."""

    name: str
    width: Width
    value: Any


@frozen(eq=False)
class MessageType:
    """Name, fields and class of a message."""

    name: str
    """ROS name, such as `sensor_msgs/msg/Imu`."""
    cls: type
    fields: tuple[Field, ...]
    constants: tuple[Constant, ...] = field(default=(), repr=False)

    def parts(self) -> Iterator["MessageType"]:
        """Yield the messages within, each once, however deep, each before its own parts."""
        found: dict[str, MessageType] = {}
        _collect(self, found)
        yield from found.values()


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
    hints = _hints(cls)
    around = _under_way.set((*_under_way.get(), cls))
    try:
        fields = tuple(
            attrs.evolve(
                _field(one.name, alias, hints[one.name], f"{cls.__name__}.{one.name}"),
                is_keyword=bool(one.kw_only),
            )
            for one, alias in _declared(cls)
        )
    finally:
        _under_way.reset(around)
    return MessageType(name, cls, fields, tuple(_constants(cls, hints)))


def _hints(cls: type) -> dict[str, Any]:
    try:
        return typing.get_type_hints(cls, include_extras=True)
    except NameError as error:
        # Such as a class within a function, whose names cannot be found later.
        raise TypeError(
            f"{cls.__name__}: an annotation cannot be read: {error}; declare the message at the top"
            " of a module, or leave out `from __future__ import annotations`"
        ) from None


def _declared(cls: Any) -> list[tuple[Any, str]]:
    """Return the fields of an attrs class or a dataclass, with their names in the constructor."""
    if attrs.has(cls):
        return [(one, one.alias) for one in attrs.fields(cls) if one.init]
    # Whoever has made a dataclass has imported it, and most programs never do.
    import dataclasses  # noqa: PLC0415 - as said

    return [(one, one.name) for one in dataclasses.fields(cls) if one.init]


def _collect(of: MessageType, found: dict[str, MessageType]) -> None:
    for one in of.fields:
        if isinstance(one.element, MessageType) and one.element.name not in found:
            found[one.element.name] = one.element
            _collect(one.element, found)


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
    if not inner:
        raise TypeError(f"{where}: an array of ROS has elements")
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
    if base in _under_way.get():
        raise TypeError(f"{where}: a message of ROS does not contain itself")
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
