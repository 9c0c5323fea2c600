"""Answers about parameters, and the request to set them."""

from collections.abc import Iterable
from typing import Any

from rosbase.contracts.node_connection import NodeConnection
from rosbase.control.answers.lookup import all_nodes, connection_of, find_node
from rosbase.control.on_loop import on_loop
from rosbase.control.requests import Answerer, Later, Request
from rosbase.control.session import Session
from rosbase.errors import ControlError, ParameterError
from rosbase.parameters import (
    Parameter,
    ParameterKind,
    ParameterSpec,
    SetParametersResult,
    from_outside,
    parse_text,
)
from rosbase.parameters.described import constraints, value_range

__all__ = ["ANSWERS"]


def _list(__: Session, request: Request) -> dict[str, Any]:
    name = request.text("node", "")
    if name:
        _, node = find_node(name)
        # The names of a plain node are relative to its key.
        known_as = node.name if name in (node.name, node.name.lstrip("/")) else name
        return {"nodes": {known_as: connection_of(node).parameter_names()}}
    # Plain nodes share the name of their manager, which has their parameters.
    found: dict[str, list[str]] = {}
    for program, node in all_nodes():
        if node.connection is None or node.name in found:
            continue
        if node.name != program.name or node.connection is program.backend:
            found[node.name] = node.connection.parameter_names()
    return {"nodes": found}


def _get(__: Session, request: Request) -> dict[str, Any]:
    _, node = find_node(request.text("node"))
    connection = connection_of(node)
    names = _names(connection, request)
    return {"node": node.name, "values": {name: _value(connection, name) for name in names}}


def _describe(__: Session, request: Request) -> dict[str, Any]:
    _, node = find_node(request.text("node"))
    connection = connection_of(node)
    names = _names(connection, request)
    return {"node": node.name, "descriptors": {n: _descriptor(_spec(connection, n)) for n in names}}


def _set(_: Session, request: Request) -> Later:
    program, node = find_node(request.text("node"))
    connection = connection_of(node)
    values = request.arguments.get("values")
    if not isinstance(values, dict):
        raise ControlError("values is an object of names and values", "invalid")
    together = request.flag("atomically", default=False)

    def change() -> dict[str, Any]:
        change_all = _set_together if together else _set_each
        results = change_all(connection, values)
        return {
            "node": node.name,
            "results": {
                name: {"successful": result.successful, "reason": result.reason}
                for name, result in results.items()
            },
        }

    return on_loop(request, program, change)


def _set_each(connection: NodeConnection, values: dict[str, Any]) -> dict[str, SetParametersResult]:
    return {name: _set_some(connection, {name: value}) for name, value in values.items()}


def _set_together(
    connection: NodeConnection, values: dict[str, Any]
) -> dict[str, SetParametersResult]:
    return dict.fromkeys(values, _set_some(connection, values))


def _set_some(connection: NodeConnection, values: dict[str, Any]) -> SetParametersResult:
    try:
        given = [_parameter(connection, name, value) for name, value in values.items()]
        return connection.set_parameters(given)
    except (ControlError, ParameterError) as error:
        return SetParametersResult(successful=False, reason=str(error))


def _parameter(connection: NodeConnection, name: str, value: Any) -> Parameter[Any]:
    spec = _spec(connection, name)
    text = value.get("text") if isinstance(value, dict) else value
    for part in text if isinstance(text, list) else [text]:
        if isinstance(part, str) and not _is_unicode(part):
            # It could be neither printed nor sent.
            raise ControlError(f"{name}: {ascii(part)[:200]} has half a surrogate", "invalid")
    if isinstance(value, dict):
        if not isinstance(text, str):
            raise ControlError(f"{name}: an object as value has a text", "invalid")
        return Parameter(name, parse_text(spec, text))
    return Parameter(name, from_outside(spec, value))


def _is_unicode(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _names(connection: NodeConnection, request: Request) -> Iterable[str]:
    names = request.texts("names")
    known = connection.parameter_names()
    if names is None:
        return known
    for name in names:
        if name not in known:
            raise _unknown(name, known)
    return names


def _spec(connection: NodeConnection, name: str) -> ParameterSpec:
    try:
        return connection.describe_parameter(name)
    except ParameterError:
        raise _unknown(name, connection.parameter_names()) from None


def _unknown(name: str, known: Iterable[str]) -> ControlError:
    from difflib import get_close_matches

    near = get_close_matches(name, list(known))
    return ControlError(f"parameter {name[:200]!r} has not been declared", "unknown", near)


def _value(connection: NodeConnection, name: str) -> dict[str, Any]:
    kind = _spec(connection, name).kind
    return {"type": _type(kind), "value": _plain(connection.get_parameter(name).value)}


def _descriptor(spec: ParameterSpec) -> dict[str, Any]:
    limits = value_range(spec)
    return {
        "type": _type(spec.kind),
        "description": spec.description,
        "constraints": constraints(spec),
        "read_only": spec.read_only,
        "range": None if limits is None else list(limits),
        "change_time": spec.change_time,
        "default": _plain(spec.default),
    }


def _type(kind: ParameterKind) -> str:
    """Return the name of a type in rcl_interfaces/ParameterType, in small letters."""
    return kind.name.lower()


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: bytes as whole numbers."""
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if isinstance(value, (list, tuple)) or hasattr(value, "tolist"):
        return [item[0] if isinstance(item, bytes) else item for item in value]
    return value


ANSWERS: dict[str, Answerer] = {
    "parameter.list": _list,
    "parameter.get": _get,
    "parameter.describe": _describe,
    "parameter.set": _set,
}
