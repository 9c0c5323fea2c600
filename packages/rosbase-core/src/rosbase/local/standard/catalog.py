"""The names and types of the standard services, without importing any of them."""

from collections.abc import Mapping
from importlib import import_module

__all__ = [
    "LIFECYCLE",
    "PARAMETERS",
    "PARAMETER_EVENT",
    "TRANSITION_EVENT",
    "TYPES",
    "class_of",
    "standard_type",
]

LIFECYCLE = "lifecycle"
"""Kind of the services of a lifecycle node."""

PARAMETERS = "parameters"
"""Kind of the services for the parameters of a node."""

_LIFECYCLE_TYPES = "rosbase.messages.lifecycle_msgs"
_PARAMETER_TYPES = "rosbase.messages.rcl_interfaces"

TRANSITION_EVENT = f"{_LIFECYCLE_TYPES}.TransitionEvent"
"""Type of the messages on `transition_event`."""

PARAMETER_EVENT = f"{_PARAMETER_TYPES}.ParameterEvent"
"""Type of the messages on `/parameter_events`."""

_AVAILABLE_TRANSITIONS = f"{_LIFECYCLE_TYPES}._get_available_transitions.GetAvailableTransitions"

TYPES: Mapping[str, Mapping[str, str]] = {
    LIFECYCLE: {
        "change_state": f"{_LIFECYCLE_TYPES}._change_state.ChangeState",
        "get_state": f"{_LIFECYCLE_TYPES}._get_state.GetState",
        "get_available_states": f"{_LIFECYCLE_TYPES}._get_available_states.GetAvailableStates",
        "get_available_transitions": _AVAILABLE_TRANSITIONS,
        "get_transition_graph": _AVAILABLE_TRANSITIONS,
    },
    PARAMETERS: {
        "describe_parameters": f"{_PARAMETER_TYPES}._describe_parameters.DescribeParameters",
        "get_parameters": f"{_PARAMETER_TYPES}._get_parameters.GetParameters",
        "get_parameter_types": f"{_PARAMETER_TYPES}._get_parameter_types.GetParameterTypes",
        "list_parameters": f"{_PARAMETER_TYPES}._list_parameters.ListParameters",
        "set_parameters": f"{_PARAMETER_TYPES}._set_parameters.SetParameters",
        "set_parameters_atomically": (
            f"{_PARAMETER_TYPES}._set_parameters_atomically.SetParametersAtomically"
        ),
    },
}
"""By kind, the type of each service, as `type_name` has it."""


def standard_type(kind: str, service: str) -> str:
    """Return the type of a service; empty if there is none of that name and kind."""
    return TYPES.get(kind, {}).get(service, "")


def class_of(type_name: str) -> type:
    """Return the class of that name, as the catalog has it."""
    module, _, own = type_name.rpartition(".")
    found: type = getattr(import_module(module), own)
    return found
