"""The structure of a message as plain data: its ROS name, its fields and its constants."""

from collections.abc import Iterator, Sequence
from enum import Enum
from typing import Any, NamedTuple

from rosbase.messages.widths import Width

__all__ = ["Constant", "Field", "Kind", "MessageType"]


class Kind(Enum):
    """How many elements a field has."""

    ONE = "one"
    ARRAY = "array"
    SEQUENCE = "sequence"


class Field(NamedTuple):
    """One field of a message."""

    name: str
    alias: str
    """Name of its argument in the constructor, or of its value in plain data."""
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
    default: Any = None
    """Value of a message that says nothing else, if it is not zero or empty."""


class Constant(NamedTuple):
    """One constant of a message."""

    name: str
    width: Width
    value: Any


class MessageType:
    """Name, fields and class of a message."""

    __slots__ = ("cls", "constants", "fields", "name")

    def __init__(
        self,
        name: str,
        cls: type,
        fields: Sequence[Field],
        constants: Sequence[Constant] = (),
    ) -> None:
        self.name = name
        """ROS name, such as `sensor_msgs/msg/Imu`."""
        self.cls = cls
        """Class of its objects; `dict` if it is known by its schema only."""
        self.fields = tuple(fields)
        self.constants = tuple(constants)

    def __repr__(self) -> str:
        return f"MessageType({self.name!r}, {self.fields!r})"

    def parts(self) -> Iterator["MessageType"]:
        """Yield the messages within, each once, however deep, each before its own parts."""
        found: dict[str, MessageType] = {}
        _collect(self, found)
        yield from found.values()


def _collect(of: MessageType, found: dict[str, MessageType]) -> None:
    for one in of.fields:
        if isinstance(one.element, MessageType) and one.element.name not in found:
            found[one.element.name] = one.element
            _collect(one.element, found)
