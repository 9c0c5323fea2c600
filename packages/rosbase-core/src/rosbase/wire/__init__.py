"""Messages as bytes, without ROS: CDR, schemas, type hashes.

Everything is compiled or computed once for a message class, at its first use.
"""

from typing import Any, TypeVar

from rosbase.wire.description import MessageType, describe
from rosbase.wire.prepared import maker, packer
from rosbase.wire.reader import reader
from rosbase.wire.schema import schema
from rosbase.wire.type_hash import dds_type_name, type_hash
from rosbase.wire.writer import writer

__all__ = [
    "MessageType",
    "dds_type_name",
    "describe",
    "deserialize",
    "maker",
    "packer",
    "reader",
    "schema",
    "serialize",
    "type_hash",
    "writer",
]

MessageT = TypeVar("MessageT")


def serialize(message: Any) -> bytes:
    """Return a message as CDR, as `rclpy.serialization.serialize_message` does.

    Raises:
        TypeError: It is no message, or a field has a value of the wrong kind; the text names it.
        ValueError: A value is out of the range of its field; the text names it.
    """
    return writer(type(message))(message)


def deserialize(data: bytes, message_type: type[MessageT]) -> MessageT:
    """Return the message of that class in CDR of either byte order.

    Raises:
        TypeError: The class is no message.
        WireError: The bytes are no such message.
    """
    message: MessageT = reader(message_type)(data)
    return message
