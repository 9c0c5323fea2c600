"""Parameters that a node was given from outside, and files that have none for it."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rclpy.parameter import Parameter as RosParameter

__all__ = ["given_parameters", "name_strange_files"]


def given_parameters(node: Any) -> dict[str, Any]:
    """Return the values that the command line and its files have for an rclpy node, by name."""
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
        files: By the name of a file: the nodes that it names, with their parameters.
        names: The names of the parameters that the node was given.
        node_name: The full name of the node.
        warn: Called with a line for each file.
    """
    given = set(names)
    for file, sections in files.items():
        if sections and not any(given & set(parameters) for parameters in sections.values()):
            others = ", ".join(sorted(f"/{section.lstrip('/')}" for section in sections))
            warn(f"{file} has no parameters for {node_name}, only for {others}")
