"""Answers about nodes."""

from collections.abc import Iterable
from typing import Any

from rosbase.contracts.graph import Graph, ServiceEnd, TopicEnd
from rosbase.control.answers.lookup import all_nodes, find_node
from rosbase.control.programs import Program, RunningNode
from rosbase.control.requests import Answerer, Request
from rosbase.control.session import Session
from rosbase.errors import BackendError

__all__ = ["ANSWERS"]


def _list(_: Session, __: Request) -> dict[str, Any]:
    return {"nodes": [_described(program, node) for program, node in all_nodes()]}


def _info(_: Session, request: Request) -> dict[str, Any]:
    program, node = find_node(request.text("name"))
    names = [] if node.connection is None else node.connection.parameter_names()
    return {**_described(program, node), "parameters": len(names), **_ends(program, node.name)}


def _ends(program: Program, name: str) -> dict[str, Any]:
    """Return the topics and services of a node, each once."""
    try:
        graph = program.backend.graph() if program.backend is not None else Graph()
    except BackendError:
        graph = Graph()
    return {
        kind: _names(end for end in getattr(graph, kind) if end.node == name)
        for kind in ("publishers", "subscriptions", "services", "clients")
    }


def _names(ends: Iterable[TopicEnd | ServiceEnd]) -> list[dict[str, str]]:
    found = sorted({(end.name, end.type_name) for end in ends})
    return [{"name": name, "type": type_name} for name, type_name in found]


def _described(program: Program, node: RunningNode) -> dict[str, Any]:
    return {
        "name": node.name,
        "program": program.name,
        "class": node.class_name,
        "key": node.key,
        "lifecycle": None if node.lifecycle is None else node.lifecycle.get_state().label,
    }


ANSWERS: dict[str, Answerer] = {"node.list": _list, "node.info": _info}
