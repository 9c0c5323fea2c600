"""How requests and answers travel: as ROS messages, built of the bytes that rosbase writes.

rclpy takes and gives no bytes here. It reads and writes them itself for messages of rosbase, so
their fields follow the same rules as on topics.
"""

from collections.abc import Callable
from typing import Any

from attrs import frozen
from rclpy.serialization import deserialize_message, serialize_message

from rosbase.messages.fields import ros_type
from rosbase.wire import reader, writer
from rosbase.wire.values import name_of
from rosbase_ros2.courier import require_same, ros_class

__all__ = ["ServiceCourier", "service_courier"]

_REQUEST, _RESPONSE = "_Request", "_Response"


@frozen
class Way:
    """Turns the messages of one direction into ROS messages, and back."""

    to_ros: Callable[[Any], Any]
    """Returns the ROS message. TypeError or ValueError names a field that cannot be sent."""
    from_ros: Callable[[Any], Any]
    """Returns the message of the program."""


@frozen
class ServiceCourier:
    """The type of a service for rclpy, and the ways of its requests and answers."""

    ros_type: Any
    """Type of the service on the network."""
    request: Way
    response: Way
    is_native: bool
    """Whether the program uses ROS messages, which it may change at any time."""


def service_courier(srv_type: Any) -> ServiceCourier:
    """Return the courier of a type of services.

    Raises:
        TypeError: ROS has no such type, or one with other fields; the text says what to do.
    """
    if all(_is_ros(part) for part in (srv_type, srv_type.Request, srv_type.Response)):
        way = Way(_same, _same)
        return ServiceCourier(srv_type, way, way, is_native=True)
    found = ros_class(_service_name(srv_type), srv_type)
    return ServiceCourier(
        found,
        _way(srv_type.Request, found.Request),
        _way(srv_type.Response, found.Response),
        is_native=False,
    )


def _service_name(srv_type: Any) -> str:
    """Return the name of a type in ROS, such as `std_srvs/srv/Trigger`."""
    request, response = ros_type(srv_type.Request), ros_type(srv_type.Response)
    if request and response and request.endswith(_REQUEST) and response.endswith(_RESPONSE):
        name = request.removesuffix(_REQUEST)
        if name == response.removesuffix(_RESPONSE):
            return name
    raise TypeError(
        f"{name_of(srv_type)} is a type of neither rosbase nor ROS: its classes Request and"
        " Response are no messages such as pkg/srv/Name_Request and pkg/srv/Name_Response"
    )


def _way(msg_type: type, ros: Any) -> Way:
    require_same(msg_type, ros)
    write, read = writer(msg_type), reader(msg_type)
    return Way(
        lambda message: deserialize_message(write(message), ros),
        lambda message: read(serialize_message(message)),
    )


def _is_ros(kind: Any) -> bool:
    return hasattr(kind, "_TYPE_SUPPORT")


def _same(message: Any) -> Any:
    return message
