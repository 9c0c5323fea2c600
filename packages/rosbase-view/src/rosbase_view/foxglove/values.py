"""Values of parameters, as rosbase and as Foxglove write them. Pure."""

from typing import Any

from foxglove import Parameter, ParameterType

__all__ = ["from_parameter", "to_parameter"]

_FLOATS = {"double": ParameterType.Float64, "double_array": ParameterType.Float64Array}


def to_parameter(name: str, kind: str, value: Any) -> Parameter:
    """Return a parameter for clients.

    Args:
        name: Its name.
        kind: Its type, as the control socket names it: `double_array`.
        value: Its value, as the control socket sends it: bytes as a list of whole numbers.
    """
    if kind == "byte_array":
        return Parameter(name, value=bytes(value), type=ParameterType.ByteArray)
    if kind == "double":
        value = float(value)
    elif kind == "double_array":
        value = [float(one) for one in value]
    return Parameter(name, value=value, type=_FLOATS.get(kind))


def from_parameter(parameter: Parameter) -> Any:
    """Return the value that a client has given, as the control socket takes it."""
    value = parameter.get_value()
    return list(value) if isinstance(value, bytes) else value
