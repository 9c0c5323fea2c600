"""From CDR to an object of a message class."""

from collections.abc import Callable
from typing import Any, TypeVar

import attrs

from rosbase.wire.description import describe
from rosbase.wire.once import once_per_class
from rosbase.wire.reading import Values, compiled_reader
from rosbase.wire.source import Source
from rosbase.wire.structure import MessageType

__all__ = ["deserialize", "reader"]

MessageT = TypeVar("MessageT")

_OUR_OWN = "rosbase.messages."


def deserialize(data: bytes, message_type: type[MessageT]) -> MessageT:
    """Return the message of that class in CDR of either byte order.

    Raises:
        TypeError: The class is no message.
        WireError: The bytes are no such message.
    """
    message: MessageT = reader(message_type)(data)
    return message


@once_per_class
def reader(cls: type) -> Callable[[bytes], Any]:
    """Return the function that reads messages of a class.

    It raises WireError for bytes that are no such message. Buffers of the message are views of the
    bytes, without a copy.

    Raises:
        TypeError: The class is no message.
    """
    return compiled_reader(describe(cls), _make)


def _make(source: Source, building: list[str], of: MessageType, values: Values) -> str:
    """Return the variable of a message, after the lines that make it."""
    made, kind = source.new("made"), source.name_of(of.cls, "kind")
    if _can_be_filled(of):
        # What has been read has the right types: no constructor, which would check them.
        building.append(f"{made} = {source.name_of(object.__new__, 'new')}({kind})")
        for one, value in values:
            put = source.name_of(getattr(of.cls, one.name).__set__, "put")
            building.append(f"{put}({made}, {value})")
    else:
        arguments = ", ".join(f"{one.alias}={value}" for one, value in values)
        building.append(f"{made} = {kind}({arguments})")
    return made


def _can_be_filled(of: MessageType) -> bool:
    """Return whether a class is one of ours, whose slots are all there is to its instances."""
    return (
        of.cls.__module__.startswith(_OUR_OWN)
        and attrs.has(of.cls)
        and not hasattr(of.cls, "__attrs_post_init__")
        and all(hasattr(getattr(of.cls, one.name, None), "__set__") for one in of.fields)
    )
