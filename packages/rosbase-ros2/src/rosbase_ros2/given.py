"""Parameters that a node got from outside, and parameter files that name no such node."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol, TypeVar

from rclpy.parameter import Parameter as RosParameter

from rosbase_ros2.qos_overrides import PREFIX

__all__ = ["given_parameters", "name_strange_files", "name_strange_parameters", "own_first"]

ValueT = TypeVar("ValueT")


class GivenNode(Protocol):
    """A node that is given parameters from outside."""

    @property
    def given_names(self) -> list[str]: ...

    def has_parameter(self, name: str) -> bool: ...

    def name_undeclared(self, names: Iterable[str]) -> None: ...


def given_parameters(node: Any) -> dict[str, Any]:
    """Return the values for an rclpy node on the command line and in its files, by name."""
    with node.handle:
        given = node.handle.get_parameters(RosParameter)
    return {name: parameter.value for name, parameter in given.items()}


def own_first(given: Mapping[str, ValueT], prefix: str) -> dict[str, ValueT]:
    """Return the given values of a node, also under the names that they have in the node.

    Args:
        given: The values; those that begin with the prefix are for this node alone, and win.
        prefix: Such as `left.`; empty if there are none for this node alone.
    """
    start = prefix or "\0"
    own = {name.removeprefix(start): given[name] for name in given if name.startswith(start)}
    return {**given, **own}


def name_strange_files(
    files: Mapping[str, Mapping[str, Iterable[str]]],
    given: Mapping[str, Iterable[str]],
    warn: Callable[[str], object],
) -> None:
    """Warn of parameter files that have nothing for any node, such as one with a misspelt name.

    Args:
        files: Nodes in each file with their parameters, by the name of the file.
        given: Names of the given parameters of each node, by the full name of the node.
        warn: Called with a line for each file.
    """
    known = {name for names in given.values() for name in names}
    nodes = ", ".join(given)
    for file, sections in files.items():
        if sections and not any(known & set(parameters) for parameters in sections.values()):
            others = ", ".join(sorted(f"/{section.lstrip('/')}" for section in sections))
            warn(f"{file} has no parameters for {nodes}, only for {others}")


def name_strange_parameters(nodes: Sequence["GivenNode"], claimed: tuple[str, ...]) -> None:
    """Warn of parameters that are given to nodes of this process, and that none has declared.

    Args:
        nodes: The nodes; what is given to several, as by `-p`, is named once.
        claimed: Beginnings of names that are meant for other nodes, such as `camera.`.
    """
    said: set[str] = set()
    for node in nodes:
        missing = [
            name
            for name in node.given_names
            if not name.startswith((PREFIX, *claimed))
            and name not in said
            and not any(other.has_parameter(name) for other in nodes)
        ]
        said.update(missing)
        if missing:
            node.name_undeclared(missing)
