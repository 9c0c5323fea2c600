"""Messages of ROS with the values of ours, by the description of our class."""

from array import array
from importlib import import_module
from typing import Any

from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.structure import Field, Kind, MessageType

__all__ = ["as_ros", "ros_class"]


def ros_class(name: str) -> Any:
    """The class of ROS of that name, such as `std_srvs/srv/SetBool_Request`."""
    package, kind, own = name.split("/")
    module = import_module(f"{package}.{kind}")
    if kind == "msg":
        return getattr(module, own)
    service, _, part = own.rpartition("_")
    return getattr(getattr(module, service), part)


def as_ros(message: Any, of: MessageType) -> Any:
    """The message of ROS with the same values."""
    return ros_class(of.name)(
        **{one.name: _value(getattr(message, one.name), one) for one in of.fields}
    )


def _value(value: Any, one: Field) -> Any:
    if one.kind is Kind.ONE:
        return _element(value, one)
    values = value.tolist() if hasattr(value, "tolist") else value
    if one.element in TYPECODES and one.element not in (Width.BYTE, Width.BOOL):
        assert isinstance(one.element, Width)
        if one.kind is Kind.SEQUENCE:
            return array(TYPECODES[one.element], values)
        numpy: Any = import_module("numpy")
        return numpy.array(values, one.element.value.replace("char", "uint8"))
    return [_element(element, one) for element in values]


def _element(value: Any, one: Field) -> Any:
    if isinstance(one.element, MessageType):
        return as_ros(value, one.element)
    # ROS has an octet as bytes.
    return bytes([value]) if one.element is Width.BYTE else value
