"""The nodes of each topic and service, as links of a graph. Pure."""

from collections.abc import Mapping
from typing import NamedTuple

from foxglove import ConnectionGraph

from rosbase.control.shapes import Endpoint, Topic

__all__ = ["Links", "links", "to_graph"]


class Links(NamedTuple):
    """Names of nodes, by the topic or the service."""

    published: dict[str, list[str]]
    subscribed: dict[str, list[str]]
    offered: dict[str, list[str]]


def links(topics: Mapping[str, Topic], services: Mapping[str, list[str]]) -> Links:
    """Return the nodes of each topic and service, by the name that clients see."""
    return Links(
        {name: _nodes(topic["publishers"]) for name, topic in topics.items()},
        {name: _nodes(topic["subscriptions"]) for name, topic in topics.items()},
        {name: sorted(set(nodes)) for name, nodes in services.items()},
    )


def _nodes(ends: list[Endpoint]) -> list[str]:
    return sorted({end["node"] for end in ends})


def to_graph(found: Links) -> ConnectionGraph:
    """Return it as the server takes it."""
    graph = ConnectionGraph()
    for name, nodes in found.published.items():
        if nodes:
            graph.set_published_topic(name, nodes)
    for name, nodes in found.subscribed.items():
        if nodes:
            graph.set_subscribed_topic(name, nodes)
    for name, nodes in found.offered.items():
        graph.set_advertised_service(name, nodes)
    return graph
