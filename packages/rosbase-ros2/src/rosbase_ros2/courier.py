"""How messages of a class travel: as bytes that rosbase writes, or as ROS messages."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from attrs import frozen

from rosbase.messages.fields import Width, ros_type
from rosbase.wire import describe, reader, writer
from rosbase.wire.structure import Field, Kind, MessageType
from rosbase_ros2.conversion import Conversions

__all__ = ["Courier", "courier_of", "require_same", "ros_class"]

# Packages of messages that the package index of the wheels of ROS does not have.
_WITHOUT_WHEEL = ("tf2_msgs",)
# What rclpy calls the primitive types.
_NAMES = {
    Width.BOOL: "boolean",
    Width.BYTE: "octet",
    Width.CHAR: "uint8",
    Width.FLOAT32: "float",
    Width.FLOAT64: "double",
}


@frozen
class Courier:
    """The class of a topic's messages for the program and for rclpy, and the way between."""

    msg_type: type
    """Message class that programs publish and receive."""
    ros_type: type
    """ROS message class on the network."""
    encode: Callable[[Any], Any]
    """Returns what rclpy publishes for a message: bytes or a ROS message.

    TypeError or ValueError names a field that cannot be sent.
    """
    decode: Callable[[Any], Any]
    """Returns the message for what rclpy delivers."""
    is_raw: bool
    """Whether both are bytes. rclpy then builds no message, which costs many times as much."""


def courier_of(msg_type: Any, conversions: Conversions) -> Courier:
    """Return the courier of a message class.

    Raises:
        TypeError: ROS has no such message, or one with other fields; the text says what to do.
        PluginError: A plugin's conversion for it is unusable.
    """
    name = ros_type(msg_type)
    if name is None or conversions.is_converted(msg_type):
        converter = conversions.of(msg_type)
        return Courier(
            msg_type, converter.ros_type, converter.to_ros, converter.from_ros, is_raw=False
        )
    found = ros_class(name, msg_type)
    require_same(msg_type, found)
    return Courier(msg_type, found, writer(msg_type), reader(msg_type), is_raw=True)


def ros_class(name: str, msg_type: type) -> Any:
    """Return the class of ROS for one of rosbase.

    Args:
        name: Its name in ROS, such as `std_srvs/srv/Trigger`.
        msg_type: The class of rosbase, for errors.

    Raises:
        TypeError: ROS has none; the text says what to install.
    """
    package, kind, own = name.split("/")
    try:
        module = import_module(f"{package}.{kind}")
    except ModuleNotFoundError:
        wheel = f"ros-jazzy-{package.replace('_', '-')}"
        install = f"pip install {wheel}, or "
        raise TypeError(
            f"{msg_type.__name__} is {name} in ROS, and {package} is not installed:"
            f" {'' if package in _WITHOUT_WHEEL else install}source a workspace that has it"
        ) from None
    found = getattr(module, own, None)
    if found is None:
        raise TypeError(f"{msg_type.__name__} is {name} in ROS, and {package} has no {own}")
    return found


def require_same(msg_type: type, theirs: Any) -> None:
    """Refuse a class whose bytes differ from the ROS message's.

    Raises:
        TypeError: They are not; the text names the first field that differs.
    """
    _require_same(describe(msg_type), theirs)


def _require_same(of: MessageType, found: Any) -> None:
    theirs = list(found.get_fields_and_field_types().items())
    ours = [(one.name, _named(one)) for one in of.fields]
    if ours != theirs:
        own, other = next(
            (mine, its)
            for mine, its in zip([*ours, None], [*theirs, None], strict=False)
            if mine != its
        )
        raise TypeError(
            f"{of.cls.__name__} differs from {of.name} of ROS: it has {_told(own)}, where ROS has"
            f" {_told(other)}"
        )
    for one in of.fields:
        if isinstance(one.element, MessageType):
            _require_same(one.element, ros_class(one.element.name, one.element.cls))


def _told(field: tuple[str, str] | None) -> str:
    return f"{field[1]} {field[0]}" if field else "no more fields"


def _named(of: Field) -> str:
    """Return the type of a field as rclpy writes it."""
    if isinstance(of.element, MessageType):
        package, _, name = of.element.name.split("/")
        text = f"{package}/{name}"
    else:
        text = _NAMES.get(of.element, of.element.value)
    if of.text_limit:
        text += f"<{of.text_limit}>"
    if of.kind is Kind.ARRAY:
        return f"{text}[{of.size}]"
    if of.kind is Kind.SEQUENCE:
        return f"sequence<{text}, {of.size}>" if of.size else f"sequence<{text}>"
    return text
