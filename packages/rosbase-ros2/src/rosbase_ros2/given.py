"""Parameters that a node got from outside, and parameter files that name no such node."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rclpy.parameter import Parameter as RosParameter

__all__ = ["given_parameters", "name_strange_files"]


def given_parameters(node: Any) -> dict[str, Any]:
    """Return the values for an rclpy node on the command line and in its files, by name."""
    with node.handle:
        given = node.handle.get_parameters(RosParameter)
    return {name: parameter.value for name, parameter in given.items()}


def name_strange_files(
    files: Mapping[str, Mapping[str, Iterable[str]]],
    names: Iterable[str],
    node_name: str,
    warn: Callable[[str], object],
) -> None:
    """Warn of parameter files that have nothing for a node, such as one with a misspelt name.

    Args:
        files: Nodes in each file with their parameters, by the name of the file.
        names: The names of the given parameters of the node.
        node_name: The full name of the node.
        warn: Called with a line for each file.
    """
    given = set(names)
    for file, sections in files.items():
        if sections and not any(given & set(parameters) for parameters in sections.values()):
            others = ", ".join(sorted(f"/{section.lstrip('/')}" for section in sections))
            warn(f"{file} has no parameters for {node_name}, only for {others}")
