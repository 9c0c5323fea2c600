"""From an object of a message class to CDR."""

from collections.abc import Callable
from typing import Any

from rosbase.wire.description import describe
from rosbase.wire.once import once_per_class
from rosbase.wire.writing import compiled_writer

__all__ = ["serialize", "writer"]


def serialize(message: Any) -> bytes:
    """Return a message as CDR, as `rclpy.serialization.serialize_message` does.

    Raises:
        TypeError: It is no message, or a field has a value of the wrong kind; the text names it.
        ValueError: A value is out of the range of its field; the text names it.
    """
    return writer(type(message))(message)


@once_per_class
def writer(cls: type) -> Callable[[Any], bytes]:
    """Return the function that writes messages of a class as `rclpy.serialization` does.

    It raises TypeError for a value of the wrong kind, and ValueError for one out of the range of
    its field; the text names the field.

    Raises:
        TypeError: The class is no message.
    """
    return compiled_writer(describe(cls), cls.__name__)
