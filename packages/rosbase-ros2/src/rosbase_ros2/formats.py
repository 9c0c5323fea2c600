"""How messages of a class look outside this process: for classes of rosbase and of ROS."""

import re
from collections.abc import Callable
from importlib import import_module
from typing import Any

from attrs import evolve
from rclpy.serialization import deserialize_message, serialize_message

from rosbase import MessageFormat, WireError, installed_plugins, one_line, type_name_of
from rosbase.messages.fields import Width
from rosbase.wire.hashes import hash_of
from rosbase.wire.plain import decoder, encoder
from rosbase.wire.schemas import schema_of
from rosbase.wire.structure import Field, Kind, MessageType
from rosbase_ros2.conversion import Accept, Conversions, Converter
from rosbase_ros2.courier import courier_of, ros_class

__all__ = [
    "find_ros_type",
    "plugin_conversions",
    "rewriter",
    "ros_format",
    "structure_of",
    "written_format",
]

_SEQUENCE = re.compile(r"sequence<(?P<element>.+?)(, (?P<size>\d+))?>")
_ARRAY = re.compile(r"(?P<element>.+)\[(?P<size>\d+)\]")
_TEXT = re.compile(r"(?P<base>w?string)<(?P<limit>\d+)>")
_WIDTHS = {
    **{width.value: width for width in Width},
    "boolean": Width.BOOL,
    "octet": Width.BYTE,
    "float": Width.FLOAT32,
    "double": Width.FLOAT64,
}


def plugin_conversions() -> Conversions:
    """Return the conversions of the installed plugins."""

    def ask(msg_type: type, accept: Accept) -> Converter | None:
        return installed_plugins().create_conversion(msg_type, "ros2", accept)

    return Conversions(ask)


def ros_format(msg_type: Any, conversions: Conversions) -> MessageFormat:
    """Return the format of a class whose messages are converted to ROS messages, or are such.

    Raises:
        TypeError: ROS has no such message.
    """
    courier = courier_of(msg_type, conversions)
    kind = courier.ros_type
    own = structure_of(kind)

    def encode(message: Any) -> bytes:
        ros = courier.encode(message) if isinstance(message, msg_type) else message
        data: bytes = ros if isinstance(ros, bytes) else serialize_message(ros)
        return data

    def decode(data: bytes) -> Any:
        if courier.is_raw:
            return courier.decode(data)
        try:
            ros = deserialize_message(data, kind)
        except Exception as error:
            raise WireError(f"{own.name}: {one_line(str(error))}") from error
        return courier.decode(ros)

    return MessageFormat(own.name, schema_of(own, with_defaults=True), hash_of(own), encode, decode)


def written_format(msg_type: Any, conversions: Conversions) -> MessageFormat:
    """Return the same format, whose bytes have no gaps of any content: for a recording."""
    form = ros_format(msg_type, conversions)
    rewrite, encode = rewriter(courier_of(msg_type, conversions).ros_type), form.encode
    return evolve(form, encode=lambda message: rewrite(bytes(encode(message))))


def find_ros_type(type_name: str) -> Any:
    """Return the class of ROS for a message or a service.

    Raises:
        TypeError: ROS has none; the text says what may help.
    """
    package, _, rest = type_name.partition("/")
    kind, _, own = rest.partition("/")
    found = None
    if package.isidentifier() and kind in ("msg", "srv"):
        try:
            found = getattr(import_module(f"{package}.{kind}"), own, None)
        except ImportError:
            found = None
    if not isinstance(found, type):
        raise TypeError(f"there is no {type_name}, neither in rosbase nor in ROS as installed")
    return found


def structure_of(ros_type: Any) -> MessageType:
    """Return the structure of a message class of ROS."""
    empty = ros_type()
    fields = [
        _field(name, text, getattr(empty, name))
        for name, text in ros_type.get_fields_and_field_types().items()
    ]
    return MessageType(type_name_of(ros_type), ros_type, fields)


def rewriter(ros_type: Any) -> Callable[[bytes], bytes]:
    """Return a function that writes a message of rclpy anew, because its gaps have any bytes."""
    own = structure_of(ros_type)
    text = schema_of(own)
    read, write = decoder(own.name, text), encoder(own.name, text)

    def rewrite(data: bytes) -> bytes:
        try:
            return write(read(data))
        except (ValueError, WireError):
            # A text that rosbase would not send; it is compared as it is.
            return data

    return rewrite


def _field(name: str, text: str, value: Any) -> Field:
    kind, size = Kind.ONE, 0
    if found := _SEQUENCE.fullmatch(text):
        kind, size = Kind.SEQUENCE, int(found["size"] or 0)
    elif found := _ARRAY.fullmatch(text):
        kind, size = Kind.ARRAY, int(found["size"])
    base, limit = (found["element"] if found else text), 0
    if bounded := _TEXT.fullmatch(base):
        base, limit = bounded["base"], int(bounded["limit"])
    if base in _WIDTHS:
        element: Width | MessageType = _WIDTHS[base]
    else:
        package, own = base.split("/")
        element = structure_of(ros_class(f"{package}/msg/{own}", type(value)))
    return Field(name, name, element, kind, size, limit, default=_default(kind, value))


def _default(kind: Kind, value: Any) -> Any:
    """Return the default of a field, if it is a number or a text, and not zero or empty."""
    if isinstance(value, bytes):
        # An octet.
        value = value[0]
    if kind is Kind.ONE and isinstance(value, (bool, int, float, str)) and value:
        return value
    return None
