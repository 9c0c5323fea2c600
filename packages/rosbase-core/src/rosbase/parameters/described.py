"""How ROS describes a parameter to other programs: the number of its type, and its limits."""

from rosbase.parameters.kinds import ParameterKind, ParameterSpec

__all__ = ["KIND_NUMBERS", "constraints", "value_range"]

KIND_NUMBERS = {kind: number for number, kind in enumerate(ParameterKind, start=1)}
"""Number of each kind in rcl_interfaces/ParameterType, where 0 stands for no value."""

_WHEN = {
    "always": "",
    "inactive": "set it while inactive or unconfigured",
    "unconfigured": "set it while unconfigured",
}
_HUGE = 1.7976931348623157e308
_INT64 = 2**63


def constraints(spec: ParameterSpec) -> str:
    """Return the limits that a descriptor has no field for, as text; empty if there are none."""
    choices = f"one of {', '.join(spec.choices)}" if spec.choices else ""
    return "; ".join(filter(None, (choices, _WHEN[spec.change_time])))


def value_range(spec: ParameterSpec) -> tuple[float, float] | None:
    """Return the least and the greatest value, which are both ints for an INTEGER.

    None if there is no limit, or for a kind whose descriptor has no range.
    """
    least, most = spec.minimum, spec.maximum
    if least is None and most is None:
        return None
    if spec.kind is ParameterKind.INTEGER:
        return (
            -_INT64 if least is None else int(least),
            _INT64 - 1 if most is None else int(most),
        )
    if spec.kind is ParameterKind.DOUBLE:
        return (
            -_HUGE if least is None else float(least),
            _HUGE if most is None else float(most),
        )
    return None
