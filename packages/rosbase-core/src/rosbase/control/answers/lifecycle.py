"""Answers about lifecycle nodes, and the request for a transition."""

from typing import Any

from rosbase.control.answers.lookup import all_nodes, find_node
from rosbase.control.on_loop import on_loop
from rosbase.control.programs import Program
from rosbase.control.requests import Answerer, Later, Request
from rosbase.control.session import Session
from rosbase.errors import ControlError, TransitionNotAvailableError
from rosbase.lifecycle import ManagedNode

__all__ = ["ANSWERS"]


def _list(_: Session, __: Request) -> dict[str, Any]:
    found = [(node.name, node.lifecycle) for _, node in all_nodes()]
    return {"nodes": [{"name": name, **_state(one)} for name, one in found if one is not None]}


def _get(__: Session, request: Request) -> dict[str, Any]:
    _, node = _managed(request.text("node"))
    available = [
        {"id": t.id, "label": t.label, "start": t.start.label, "goal": t.goal.label}
        for t in node.get_available_transitions()
    ]
    return {**_state(node), "available": available}


def _set(_: Session, request: Request) -> Later:
    program, node = _managed(request.text("node"))
    number, label = _wanted(request)
    if busy := node.describe_transition():
        # The main loop may be what runs it, and cannot be asked.
        raise ControlError(busy, "refused")

    def change() -> dict[str, Any]:
        try:
            result = node.request_transition(number, label)
        except TransitionNotAvailableError as error:
            raise ControlError(str(error), "refused") from error
        is_done = result.name == "SUCCESS"
        reason = "" if is_done else str(getattr(node, "last_error", None) or "")
        return {
            "successful": is_done,
            "result": result.name.lower(),
            "reason": reason,
            **_state(node),
        }

    return on_loop(request, program, change)


def _wanted(request: Request) -> tuple[int, str]:
    wanted = request.arguments.get("transition")
    if type(wanted) is int:
        return wanted, ""
    if isinstance(wanted, str) and wanted:
        return (int(wanted), "") if wanted.isdecimal() and len(wanted) < 4 else (0, wanted)
    raise ControlError("transition is a label or an id", "invalid")


def _managed(name: str) -> tuple[Program, ManagedNode]:
    program, node = find_node(name)
    if node.lifecycle is None:
        known = [one.name for _, one in all_nodes() if one.lifecycle is not None]
        raise ControlError(f"{node.name} is no lifecycle node", "refused", known)
    return program, node.lifecycle


def _state(node: ManagedNode) -> dict[str, Any]:
    state = node.get_state()
    return {"state": state.label, "id": state.id}


ANSWERS: dict[str, Answerer] = {
    "lifecycle.list": _list,
    "lifecycle.get": _get,
    "lifecycle.set": _set,
}
