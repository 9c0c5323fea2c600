"""When the parameters of a lifecycle node may change."""

from rosbase.lifecycle import State
from rosbase.parameters import ParameterSpec

__all__ = ["refusal"]


def refusal(spec: ParameterSpec, state: State) -> str:
    """Return why a parameter cannot change in this state of its node; empty if it can."""
    if spec.change_time == "always" or state is State.UNCONFIGURED:
        return ""
    parameter = f"parameter {spec.name}"
    if state is State.FINALIZED:
        return f"{parameter} cannot be set any more: the node is finalized"
    if spec.change_time == "unconfigured":
        return f"{parameter} cannot be set while {state.name.lower()}: set it while unconfigured"
    if state is State.INACTIVE:
        return ""
    return f"{parameter} cannot be set while active: set it while inactive or unconfigured"
