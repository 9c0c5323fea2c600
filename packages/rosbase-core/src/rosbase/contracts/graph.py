"""The graph of a backend: the publishers, subscriptions, services and clients of its nodes."""

from typing import Any

from attrs import frozen

from rosbase.messages.fields import ros_type
from rosbase.qos import QoSProfile

__all__ = ["Graph", "ServiceEnd", "TopicEnd", "type_name_of"]


@frozen
class TopicEnd:
    """A publisher or a subscription."""

    node: str
    """Full name of its node, such as `/robot`."""
    name: str
    """Full name of the topic."""
    type_name: str
    """Type of the messages, such as `sensor_msgs/msg/Imu`; for a class of Python, its name."""
    msg_type: Any = None
    """Their class, if it is known."""
    profile: QoSProfile | None = None
    """Its quality of service, if it is known."""
    dropped: int | None = None
    """Number of messages that a subscription has dropped, if it is known."""


@frozen
class ServiceEnd:
    """A service or a client."""

    node: str
    """Full name of its node."""
    name: str
    """Full name of the service."""
    type_name: str
    """Type of the service, such as `std_srvs/srv/Trigger`."""
    srv_type: Any = None
    """Its class, if it is known."""


@frozen
class Graph:
    """The ends of all nodes of a backend, at one moment."""

    nodes: tuple[str, ...] = ()
    """Full names of the nodes."""
    publishers: tuple[TopicEnd, ...] = ()
    subscriptions: tuple[TopicEnd, ...] = ()
    services: tuple[ServiceEnd, ...] = ()
    clients: tuple[ServiceEnd, ...] = ()


def type_name_of(cls: Any) -> str:
    """Return the ROS name of a class of messages or services; without one, the name of the class.

    A class that ROS has generated has its name too.
    """
    request = ros_type(getattr(cls, "Request", None))
    name = ros_type(cls) or (request.removesuffix("_Request") if request else None)
    if name:
        return name
    module, own = getattr(cls, "__module__", ""), getattr(cls, "__qualname__", str(cls))
    package, _, rest = module.partition(".")
    kind, _, file = rest.partition(".")
    if kind in ("msg", "srv", "action") and file.startswith("_"):
        return f"{package}/{kind}/{own}"
    return f"{module.replace('__mp_main__', '__main__')}.{own}"
