"""Parameters: names, types and values."""

from rosbase.parameters.checking import check_value, did_you_mean
from rosbase.parameters.kinds import (
    ChangeTime,
    Parameter,
    ParameterKind,
    ParameterSpec,
    ParameterValue,
    SetParametersResult,
)
from rosbase.parameters.written import (
    Written,
    WrittenText,
    from_outside,
    parse_text,
    parse_written,
)

__all__ = [
    "ChangeTime",
    "Parameter",
    "ParameterKind",
    "ParameterSpec",
    "ParameterValue",
    "SetParametersResult",
    "Written",
    "WrittenText",
    "check_value",
    "did_you_mean",
    "from_outside",
    "parse_text",
    "parse_written",
]
