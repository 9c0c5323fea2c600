"""Find the programs and nodes that a request names."""

from collections.abc import Sequence
from typing import TypeVar

from rosbase.contracts.node_connection import NodeConnection
from rosbase.control.programs import Program, RunningNode, running_programs
from rosbase.errors import ControlError

__all__ = ["all_nodes", "chosen_programs", "connection_of", "find_node"]

FoundT = TypeVar("FoundT")
_MOST_SHOWN = 200


def chosen_programs(name: str) -> list[Program]:
    """Return the programs of a name, or all if it is empty.

    Raises:
        ControlError: There is none of that name.
    """
    programs = list(running_programs())
    if not name:
        return programs
    found = [program for program in programs if program.name in (name, f"/{name}")]
    if not found:
        raise _unknown("program", name, [program.name for program in programs])
    return found


def all_nodes() -> list[tuple[Program, RunningNode]]:
    """Return all nodes of this process, with their programs."""
    return [(program, node) for program in running_programs() for node in program.nodes()]


def find_node(name: str) -> tuple[Program, RunningNode]:
    """Return the node of a name: a full one, one without its `/`, or the key of a plain node.

    Raises:
        ControlError: There is none, or there are several.
    """
    nodes = all_nodes()
    # Of a manager and its plain nodes, which have one name, the manager's own.
    named = [one for one in nodes if one[1].name in (name, f"/{name}") and _is_visible(*one)]
    found = named or [one for one in nodes if one[1].key == name]
    return _only(found, name, nodes)


def connection_of(node: RunningNode) -> NodeConnection:
    """Return the connection of a node.

    Raises:
        ControlError: It has none.
    """
    if node.connection is None:
        raise ControlError(f"{node.key} has no connection", "refused")
    return node.connection


def _is_visible(program: Program, node: RunningNode) -> bool:
    return node.connection is program.backend or node.name != program.name


def _only(
    found: Sequence[tuple[Program, RunningNode]],
    name: str,
    known: Sequence[tuple[Program, RunningNode]],
) -> tuple[Program, RunningNode]:
    if not found:
        names = [text for _, node in known for text in (node.name, node.key) if text]
        raise _unknown("node", name, names)
    if len(found) > 1:
        owners = [f"{program.name} ({program.class_name})" for program, _ in found]
        text = (
            f"node {name} is in {len(found)} programs of one process: {', '.join(owners)}; "
            "give each of them a name of its own"
        )
        raise ControlError(text, "ambiguous", owners)
    return found[0]


def _unknown(what: str, name: str, known: Sequence[str]) -> ControlError:
    from difflib import get_close_matches

    near = get_close_matches(name, list(dict.fromkeys(known)))
    return ControlError(f"there is no {what} {name[:_MOST_SHOWN]!r}", "unknown", near)
