"""`rosbase node list` and `info`."""

from __future__ import annotations

from rosbase.control.names import is_hidden
from rosbase.control.questions.nodes import NodeQuestions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

__all__ = ["show_info", "show_list"]

_PARTS = (
    ("Subscribers", "subscriptions"),
    ("Publishers", "publishers"),
    ("Service Servers", "services"),
    ("Service Clients", "clients"),
)


def show_list(given: Any) -> None:
    """Print the names of the nodes, one a line, as `ros2 node list` does."""
    nodes = NodeQuestions(given.program).nodes()
    # Plain nodes of a manager share its name. Two programs may have nodes of one name.
    found = {(node["name"], node["pid"]) for node in nodes}
    names = sorted(one for one in found if given.all or not is_hidden(one[0]))
    if given.count_nodes:
        print(len(names))
        return
    for name, _ in names:
        print(name)


def show_info(given: Any) -> None:
    """Print the topics and services of a node, as `ros2 node info` does."""
    questions = NodeQuestions(given.program)
    nodes = questions.nodes()
    found = questions.node(given.node)
    full = f"/{given.node.lstrip('/')}"
    print(full if full in {node["name"] for node in nodes} else given.node)
    for title, key in _PARTS:
        print(f"  {title}:")
        for one in sorted(found[key], key=lambda one: one["name"]):  # type: ignore[literal-required]  # one of its keys
            print(f"    {one['name']}: {one['type']}")
    if found.get("lifecycle"):
        print(f"  Lifecycle: {found['lifecycle']}")
