"""Answers about nodes."""

from typing import Any

from rosbase.control.answers.lookup import all_nodes, find_node
from rosbase.control.programs import Program, RunningNode
from rosbase.control.requests import Answerer, Request
from rosbase.control.session import Session

__all__ = ["ANSWERS"]


def _list(_: Session, __: Request) -> dict[str, Any]:
    return {"nodes": [_described(program, node) for program, node in all_nodes()]}


def _info(_: Session, request: Request) -> dict[str, Any]:
    program, node = find_node(request.text("name"))
    names = [] if node.connection is None else node.connection.parameter_names()
    return {**_described(program, node), "parameters": len(names)}


def _described(program: Program, node: RunningNode) -> dict[str, Any]:
    return {
        "name": node.name,
        "program": program.name,
        "class": node.class_name,
        "key": node.key,
        "lifecycle": None if node.lifecycle is None else node.lifecycle.get_state().label,
    }


ANSWERS: dict[str, Answerer] = {"node.list": _list, "node.info": _info}
