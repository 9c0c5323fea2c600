"""Names of topics, services and nodes, checked and resolved as ROS 2 does, for every backend.

Sources: design.ros2.org/articles/topic_and_service_names; rcl (`validate_topic_name.c`,
`expand_topic_name.c`); rmw (`validate_full_topic_name.c`, `validate_node_name.c`).
"""

import re

from rosbase.errors import BackendError

__all__ = ["MAX_NODE_LENGTH", "MAX_TOPIC_LENGTH", "check_node_name", "resolve_topic"]

MAX_TOPIC_LENGTH = 247
"""Maximum length of a full topic name: the limit of DDS, less the prefix that ROS adds (rmw)."""

MAX_NODE_LENGTH = MAX_TOPIC_LENGTH - len("//set_parameters_atomically")
"""Maximum length of a node name: a longer one leaves no room for the name of its longest service.
"""

_SUBSTITUTION = re.compile(r"\{(\w*)\}", re.ASCII)
_FOREIGN = re.compile(r"[^A-Za-z0-9_/~{}]")
_FOREIGN_TO_NODES = re.compile(r"[^A-Za-z0-9_]")
_SHOWN = 60


def check_node_name(name: str) -> None:
    """Refuse a node name that ROS would refuse.

    Raises:
        BackendError: The name is invalid; the message says why.
    """
    if not isinstance(name, str):
        raise BackendError(f"{name!r} is not a node name: it is not text")
    if fault := _node_fault(name):
        raise BackendError(f"{_shown(name)} is not a node name: {fault}")


def _node_fault(name: str) -> str:
    if not name:
        return "it is empty"
    if foreign := _FOREIGN_TO_NODES.search(name):
        better = _FOREIGN_TO_NODES.sub("_", name)
        hint = f"; did you mean {better}?" if len(name) < _SHOWN and not _node_fault(better) else ""
        return f"it has {foreign[0]!r}, and only letters, digits and _ are allowed{hint}"
    if name[0].isdecimal():
        return "it begins with a digit"
    if len(name) > MAX_NODE_LENGTH:
        return f"it has {len(name)} characters, and {MAX_NODE_LENGTH} are allowed"
    return ""


def resolve_topic(topic: str, node_name: str, kind: str = "topic") -> str:
    """Return the full name: `imu/data` is `/imu/data`, `~/status` is `/<node_name>/status`.

    Args:
        topic: A relative, absolute (`/`) or private (`~/`) name. `{node}` and `{ns}` stand for
            the node and its namespace.
        node_name: The name of the node, its namespace in front if there is one.
        kind: The kind of the name, for errors: the rules are the same for a `service`.

    Raises:
        BackendError: It is not a topic name; the message says why.
    """
    if not isinstance(topic, str):
        raise BackendError(f"{topic!r} is not a {kind} name: it is not text")
    space, _, node = f"/{node_name}".rpartition("/")
    if fault := _given_fault(topic):
        raise _not_a_name(topic, fault, kind)
    # As rcl has it: the root namespace is `/`.
    values = {"node": node, "ns": space or "/", "namespace": space or "/"}
    name = _SUBSTITUTION.sub(lambda found: values.get(found[1], found[0]), topic)
    if name.startswith("~"):
        name = f"{space}/{node}{name[1:]}"
    elif not name.startswith("/"):
        name = f"{space}/{name}"
    if fault := _full_fault(name):
        raise _not_a_name(topic, fault, kind)
    return name


def _given_fault(topic: str) -> str:
    """Return why the name is invalid for every node; empty if it is valid."""
    if not topic:
        return "it is empty"
    if foreign := _FOREIGN.search(topic):
        return f"it has {foreign[0]!r}, and only letters, digits, _ and / are allowed"
    if topic.rfind("~") > 0 or (topic.startswith("~") and topic[1:2] not in ("", "/")):
        return "~ is allowed at the start only, with a / after it"
    return ""


def _full_fault(name: str) -> str:
    """Return why a full name is invalid; empty if it is valid."""
    if "{" in name or "}" in name:
        return "{...} is one of {node}, {ns} and {namespace}"
    if _FOREIGN.search(name):
        return f"for this node it is {name!r}"
    if len(name) > MAX_TOPIC_LENGTH:
        return f"its full name has {len(name)} characters, and {MAX_TOPIC_LENGTH} are allowed"
    for part in name[1:].split("/"):
        if not part:
            return "a / must be followed by a name"
        if part[0].isdecimal():
            return f"{part!r} begins with a digit"
    return ""


def _not_a_name(topic: str, fault: str, kind: str) -> BackendError:
    return BackendError(f"{_shown(topic)} is not a {kind} name: {fault}")


def _shown(name: str) -> str:
    shown = repr(name)
    return shown if len(shown) <= _SHOWN else f"{shown[: _SHOWN - 3]}..."
