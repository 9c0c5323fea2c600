"""Parameters that a node was given from outside, and those of them that mean nothing here."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml
from rclpy.parameter import Parameter as RosParameter

from rosbase import did_you_mean
from rosbase_ros2.qos_overrides import PREFIX

__all__ = ["given_parameters", "name_strange_files", "name_undeclared"]

_FILE = "--params-file"
_PARAMETERS = "ros__parameters"


def given_parameters(node: Any) -> dict[str, Any]:
    """Return the values that the command line and its files have for an rclpy node, by name."""
    with node.handle:
        given = node.handle.get_parameters(RosParameter)
    return {name: parameter.value for name, parameter in given.items()}


def name_undeclared(node: Any, names: Iterable[str], warn: Callable[[str], object]) -> None:
    """Warn of parameters that were given to a node which has declared no such parameter."""
    known = node.list_parameters([], 0).names
    for name in sorted(names):
        if not name.startswith(PREFIX) and not node.has_parameter(name):
            hint = did_you_mean(name, known)
            warn(f"parameter {name} is set from outside, and this node does not have it{hint}")


def name_strange_files(
    arguments: Iterable[str], names: Iterable[str], node_name: str, warn: Callable[[str], object]
) -> None:
    """Warn of parameter files that have nothing for a node, such as one with a misspelt name.

    Args:
        arguments: Those for ROS on the command line.
        names: The names of the parameters that the node was given.
        node_name: The full name of the node.
        warn: Called with a line for each file.
    """
    given = set(names)
    for word, file in pairwise(arguments):
        sections = dict(_sections(_read(file))) if word == _FILE else {}
        if sections and not any(given & parameters for parameters in sections.values()):
            others = ", ".join(sorted(sections))
            warn(f"{file} has no parameters for {node_name}, only for {others}")


def _read(file: str) -> Any:
    try:
        return yaml.safe_load(Path(file).read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError):
        # rcl has read it, or has said why not.
        return None


def _sections(tree: Any, path: str = "") -> Iterator[tuple[str, set[str]]]:
    """Give each node that a file names, with the names of its parameters."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            if key == _PARAMETERS:
                yield path, set(_names(value))
            else:
                yield from _sections(value, f"{path}/{str(key).strip('/')}")


def _names(tree: Any, prefix: str = "") -> Iterator[str]:
    for key, value in tree.items() if isinstance(tree, Mapping) else ():
        if isinstance(value, Mapping):
            yield from _names(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}"
