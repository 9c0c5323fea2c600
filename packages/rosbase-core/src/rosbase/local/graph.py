"""The graph of a backend: the ends that its nodes have created, and its standard services."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rosbase.contracts.graph import Graph, ServiceEnd, TopicEnd, type_name_of
from rosbase.local.bus import Bus
from rosbase.local.standard.catalog import LIFECYCLE, TRANSITION_EVENT, TYPES
from rosbase.qos import QoSProfile

__all__ = ["Ends", "local_graph", "transition_end"]

_OUR_OWN = "rosbase.messages."
# As in rcl_lifecycle.
_EVENT_PROFILE = QoSProfile(10)


class Ends(NamedTuple):
    """The ends that the nodes of a backend have created."""

    publishers: Sequence[Any]
    subscriptions: Sequence[Any]
    services: Sequence[Any]
    clients: Sequence[Any]


def local_graph(
    nodes: Sequence[str],
    ends: Ends,
    owners: Mapping[Any, str],
    srv_types: Mapping[Any, Any],
    standard: Sequence[tuple[str, str]],
    bus: Bus,
) -> Graph:
    """Return the graph.

    Args:
        nodes: Names of the nodes; the first has created what has no owner.
        ends: The ends.
        owners: Names of the nodes that have created some of them.
        srv_types: The types of services and clients.
        standard: Full names of nodes with standard services, each with a kind of them.
        bus: The bus, which knows the types of topics.
    """

    def topic_end(end: Any, dropped: int | None = None) -> TopicEnd:
        kind = bus.type_of(end.topic)
        node = f"/{owners.get(end, nodes[0])}"
        return TopicEnd(node, end.topic, type_name_of(kind), kind, end.profile, dropped)

    def service_end(end: Any) -> ServiceEnd:
        kind = srv_types.get(end)
        node = f"/{owners.get(end, nodes[0])}"
        return ServiceEnd(node, end.service_name, type_name_of(kind), kind)

    publishers = [topic_end(end) for end in ends.publishers if bus.type_of(end.topic)]
    subscriptions = [
        topic_end(end, end.dropped) for end in ends.subscriptions if bus.type_of(end.topic)
    ]
    services = [service_end(end) for end in ends.services if end in srv_types]
    clients = [service_end(end) for end in ends.clients if end in srv_types]
    own_topics, own_services = {end.name for end in publishers}, {end.name for end in services}
    publishers += [end for end in _events(standard) if end.name not in own_topics]
    services += [end for end in _standard_services(standard) if end.name not in own_services]
    return Graph(
        tuple(dict.fromkeys(f"/{name}" for name in nodes)),
        tuple(publishers),
        tuple(subscriptions),
        tuple(services),
        tuple(clients),
    )


def _events(standard: Sequence[tuple[str, str]]) -> Iterator[TopicEnd]:
    """Yield the topics of transitions, which have a publisher once somebody listens."""
    for node, kind in standard:
        if kind == LIFECYCLE:
            yield transition_end(node)


def transition_end(node: str) -> TopicEnd:
    """Return the topic of the transitions of a node."""
    name, type_name = f"{node}/transition_event", _ros_name(TRANSITION_EVENT, "msg")
    return TopicEnd(node, name, type_name, None, _EVENT_PROFILE)


def _standard_services(standard: Sequence[tuple[str, str]]) -> Iterator[ServiceEnd]:
    for node, kind in standard:
        for service, path in TYPES[kind].items():
            yield ServiceEnd(node, f"{node}/{service}", _ros_name(path, "srv"))


def _ros_name(path: str, kind: str) -> str:
    """Return the ROS name of a class of ours, without importing it."""
    package, *_, own = path.removeprefix(_OUR_OWN).split(".")
    return f"{package}/{kind}/{own}"
