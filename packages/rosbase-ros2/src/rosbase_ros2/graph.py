"""The graph of a backend: what rclpy says of its nodes, with what rosbase knows of their ends."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.node import NodeNameNonExistentError
from rclpy.qos import HistoryPolicy, QoSProfile

from rosbase import Graph, ServiceEnd, TopicEnd, type_name_of
from rosbase_ros2.qos import from_profile
from rosbase_ros2.shared_node import SharedNode
from rosbase_ros2.taps import Taps

__all__ = ["ros_graph", "topic_end"]


def ros_graph(nodes: Sequence[SharedNode], taps: Taps) -> Graph:
    """Return the ends of the rclpy nodes of a backend.

    They are what `ros2 node info` shows: the ends of rosbase, of the program, and of rclpy and
    rcl. What is just being destroyed is left out.
    """
    known: list[Any] = [*taps.publishers, *taps.subscriptions]
    own = {id(end.inner): end for end in known}
    graphs = [_node_graph(node, own) for node in [*nodes]]
    return Graph(
        tuple(name for graph in graphs for name in graph.nodes),
        tuple(end for graph in graphs for end in graph.publishers),
        tuple(end for graph in graphs for end in graph.subscriptions),
        tuple(end for graph in graphs for end in graph.services),
        tuple(end for graph in graphs for end in graph.clients),
    )


def topic_end(node: SharedNode, inner: Any, msg_type: Any) -> TopicEnd:
    """Return the description of a publisher or a subscription of rclpy.

    Args:
        node: Its node.
        inner: The publisher or subscription.
        msg_type: Class of the messages, of rosbase or of ROS.
    """
    return TopicEnd(
        node.get_fully_qualified_name(),
        inner.topic_name,
        type_name_of(inner.msg_type),
        msg_type,
        from_profile(inner.qos_profile),
    )


def _node_graph(node: SharedNode, own: dict[int, Any]) -> Graph:
    try:
        full = node.get_fully_qualified_name()
        asked = node.get_name(), node.get_namespace()
        return Graph(
            (full,),
            tuple(
                _topic_ends(
                    node,
                    node.get_publisher_names_and_types_by_node(*asked),
                    node.publishers,
                    node.get_publishers_info_by_topic,
                    own,
                )
            ),
            tuple(
                _topic_ends(
                    node,
                    node.get_subscriber_names_and_types_by_node(*asked),
                    node.entities("subscriptions"),
                    node.get_subscriptions_info_by_topic,
                    own,
                )
            ),
            tuple(
                _service_ends(
                    full,
                    node.get_service_names_and_types_by_node(*asked),
                    node.entities("services"),
                )
            ),
            tuple(
                _service_ends(
                    full,
                    node.get_client_names_and_types_by_node(*asked),
                    node.entities("clients"),
                )
            ),
        )
    except (InvalidHandle, NodeNameNonExistentError):
        # It is being destroyed.
        return Graph()


def _topic_ends(
    node: SharedNode,
    named: Iterable[tuple[str, Sequence[str]]],
    inners: Iterable[Any],
    infos: Callable[[str], Iterable[Any]],
    own: dict[int, Any],
) -> Iterator[TopicEnd]:
    full, known = node.get_fully_qualified_name(), _by_name(inners, "topic_name")
    for name, types in named:
        for inner in known.get(name, ()):
            end = own.get(id(inner))
            kind = inner.msg_type if end is None else end.msg_type
            profile = from_profile(inner.qos_profile)
            yield TopicEnd(full, name, types[0], kind, profile, getattr(end, "dropped", None))
        if name not in known:
            # Of rcl itself, such as /rosout.
            for info in infos(name):
                if (info.node_name, info.node_namespace) == (
                    node.get_name(),
                    node.get_namespace(),
                ):
                    yield TopicEnd(full, name, types[0], None, _discovered(info.qos_profile))


def _service_ends(
    full: str, named: Iterable[tuple[str, Sequence[str]]], inners: Iterable[Any]
) -> Iterator[ServiceEnd]:
    known = _by_name(inners, "service_name")
    for name, types in named:
        kind = next((inner.srv_type for inner in known.get(name, ())), None)
        yield ServiceEnd(full, name, types[0], kind)


def _by_name(inners: Iterable[Any], attribute: str) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for inner in [*inners]:
        try:
            found.setdefault(getattr(inner, attribute), []).append(inner)
        except InvalidHandle:
            continue
    return found


def _discovered(profile: QoSProfile) -> Any:
    """Return the profile of an end that is known by discovery, which does not tell the history."""
    if profile.history is HistoryPolicy.UNKNOWN:
        profile.history = HistoryPolicy.KEEP_LAST
    return from_profile(profile)
