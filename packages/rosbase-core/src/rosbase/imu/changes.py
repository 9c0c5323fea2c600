"""Rules for when a parameter of the reader may be set, and when it takes effect."""

from collections.abc import Iterable

from rosbase.imu.checks.parameters import CHECK_PARAMETERS
from rosbase.imu.mapping import GROUPS, VECTORS
from rosbase.lifecycle import State

__all__ = ["refusal"]

# Each sample is sent with them, and they change nothing in how it is read.
_AT_ANY_TIME = frozenset({"frame_id", *(f"{group}_stddev" for group in GROUPS)})

# They make the path of a frame, which is made anew when no frame is on its way.
_BETWEEN_RUNS = frozenset(
    {
        "preset",
        *(spec.name for spec in CHECK_PARAMETERS),
        *(f"{group}_full_scale" for group in VECTORS),
    }
)
_MAPPING = "mapping."


def refusal(names: Iterable[str], state: State) -> str:
    """Return why one of these parameters cannot be set now; empty if all can.

    Args:
        names: The names of parameters of the reader.
        state: The state of the reader.
    """
    return next(filter(None, (_refusal(name, state) for name in names)), "")


def _refusal(name: str, state: State) -> str:
    if state is State.UNCONFIGURED or (name in _AT_ANY_TIME and state is not State.FINALIZED):
        return ""
    if state is State.FINALIZED:
        return f"parameter {name} cannot be set any more: the reader is finalized"
    if name not in _BETWEEN_RUNS and not name.startswith(_MAPPING):
        return f"parameter {name} takes effect at the next configure: set it while unconfigured"
    if state is State.INACTIVE:
        return ""
    return f"parameter {name} cannot be set while active: set it while inactive or unconfigured"
