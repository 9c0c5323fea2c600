"""How the messages of a class look outside this process: their name, schema and bytes."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from attrs import frozen

from rosbase.contracts.graph import type_name_of
from rosbase.messages.fields import ros_type

__all__ = ["MessageFormat", "find_type", "message_format"]


@frozen
class MessageFormat:
    """The name and the schema of a class of messages, and the way to bytes and back."""

    type_name: str
    """ROS name, such as `sensor_msgs/msg/Imu`."""
    schema: str
    """Schema of the format `ros2msg`, with the defaults of fields."""
    type_hash: str
    """RIHS01 hash; empty if it is unknown."""
    encode: Callable[[Any], bytes]
    """Returns a message as CDR. TypeError or ValueError names a field that has none."""
    decode: Callable[[bytes], Any]
    """Returns the message in CDR; WireError if it is none."""


def message_format(msg_type: Any) -> MessageFormat:
    """Return the format of a message class of rosbase.

    Raises:
        TypeError: It is none, or a field has no ROS type.
    """
    from rosbase.wire import reader, schema, type_hash, writer

    return MessageFormat(
        ros_type(msg_type) or "",
        schema(msg_type, with_defaults=True),
        type_hash(msg_type),
        writer(msg_type),
        reader(msg_type),
    )


def find_type(type_name: str) -> Any:
    """Return the class of rosbase for a message or a service.

    Args:
        type_name: Its ROS name, such as `sensor_msgs/msg/Imu` or `std_srvs/srv/Trigger`.

    Raises:
        TypeError: rosbase has none.
    """
    package, _, rest = type_name.partition("/")
    own = rest.rpartition("/")[2]
    found = None
    if package.isidentifier():
        try:
            found = getattr(import_module(f"rosbase.messages.{package}"), own, None)
        except ModuleNotFoundError:
            found = None
    if found is None or type_name_of(found) != type_name:
        raise TypeError(f"rosbase has no {type_name}")
    return found
