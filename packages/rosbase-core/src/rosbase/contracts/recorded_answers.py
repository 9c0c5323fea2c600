"""Answers that the backend of a middleware notes while its program is recorded.

A replay has no middleware. Its backend asks for the same, in the same order, and gets what was
noted.
"""

from collections.abc import Callable
from typing import Any, TypeVar

from rosbase.entries.conductor import Conductor
from rosbase.entries.outcomes import error_from_json, error_to_json
from rosbase.entries.payloads import Json, from_json, to_json
from rosbase.errors import RosbaseError, TransitionNotAvailableError
from rosbase.lifecycle import CallbackReturn, ManagedNode
from rosbase.logger import RosbaseLogger
from rosbase.parameters import Parameter

__all__ = ["change_state", "found", "parameters_from", "parameters_to", "value_from", "value_to"]

T = TypeVar("T")


def _same(value: Any) -> Any:
    return value


def found(
    conductor: Conductor,
    read: Callable[[], T],
    to: Callable[[T], Json] = _same,
    back: Callable[[Any], T] = _same,
) -> T:
    """Return the recorded result of a call of the middleware, or raise its recorded error.

    Args:
        conductor: The conductor of the program.
        read: Makes the call; in a replay, only if the recording has no answer.
        to: Returns a result as JSON.
        back: Returns the result of such JSON.

    Raises:
        RosbaseError: The call has raised it.
    """

    def ask() -> Json:
        try:
            return {"value": to(read())}
        except RosbaseError as error:
            return {"error": error_to_json(error)}

    answer: Any = conductor.fact(ask)
    if "error" in answer:
        raise error_from_json(answer["error"])
    return back(answer["value"])


def value_to(value: Any) -> Json:
    """Return the value of a parameter as JSON."""
    if isinstance(value, list) and value and isinstance(value[0], bytes):
        return {"bytes": [item[0] for item in value]}
    json: Json = value
    return json


def value_from(value: Any) -> Any:
    """Return the value of a parameter in JSON."""
    return [bytes([item]) for item in value["bytes"]] if isinstance(value, dict) else value


def parameters_to(node: str, parameters: list[Parameter[Any]]) -> bytes:
    """Return a request to set parameters of a node, as the payload of an entry."""
    values = [[parameter.name, value_to(parameter.value)] for parameter in parameters]
    return to_json({"node": node, "set": values})


def parameters_from(data: bytes) -> tuple[str, list[Parameter[Any]]]:
    """Return the node and the parameters of such a payload."""
    asked: Any = from_json(data)
    return asked["node"], [Parameter(name, value_from(value)) for name, value in asked["set"]]


def change_state(node: ManagedNode, transition_id: int, label: str, logger: RosbaseLogger) -> bool:
    """Run a transition that somebody outside has asked for; return whether it has succeeded.

    Args:
        node: The lifecycle node.
        transition_id: Number of the transition.
        label: Its label, which goes before the number.
        logger: Logs why it has not run.
    """
    try:
        return node.request_transition(transition_id, label) is CallbackReturn.SUCCESS
    except TransitionNotAvailableError as error:
        logger.warning(f"change_state refused: {error}")
    except Exception as error:
        logger.error(f"a transition raised {type(error).__name__}: {error}")
    return False
