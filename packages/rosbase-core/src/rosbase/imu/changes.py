"""When each parameter of the reader may change."""

from attrs import evolve

from rosbase.imu.checks.parameters import CHECK_PARAMETERS
from rosbase.imu.mapping import GROUPS, VECTORS
from rosbase.parameters import ChangeTime, ParameterSpec

__all__ = ["with_change_time"]

# Each sample is sent with them, and they change nothing in how it is read.
_ALWAYS = frozenset({"frame_id", *(f"{group}_stddev" for group in GROUPS)})

# They make the path of a frame, which is made anew when no frame is on its way.
_INACTIVE = frozenset(
    {
        "preset",
        *(spec.name for spec in CHECK_PARAMETERS),
        *(f"{group}_full_scale" for group in VECTORS),
    }
)
_MAPPING = "mapping."


def with_change_time(spec: ParameterSpec) -> ParameterSpec:
    """Return a parameter of the reader or of a transport, with when it may change."""
    return evolve(spec, change_time=_change_time(spec.name))


def _change_time(name: str) -> ChangeTime:
    if name in _ALWAYS:
        return "always"
    return "inactive" if name in _INACTIVE or name.startswith(_MAPPING) else "unconfigured"
