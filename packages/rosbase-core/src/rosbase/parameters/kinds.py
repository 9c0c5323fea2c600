"""Parameters and their types, which follow rcl_interfaces/ParameterType."""

import array
from enum import Enum
from typing import Generic, Literal, TypeAlias, TypeVar, get_args

from attrs import Factory, field, frozen, validators

__all__ = [
    "ELEMENTS",
    "SCALARS",
    "ChangeTime",
    "Parameter",
    "ParameterKind",
    "ParameterSpec",
    "ParameterValue",
    "SetParametersResult",
]

ParameterValue: TypeAlias = (
    bool | int | float | str | list[bool] | list[int] | list[float] | list[str] | list[bytes]
)
"""Value of a parameter. Bytes are a list of `bytes` of length 1, as in rclpy."""

ChangeTime: TypeAlias = Literal["always", "inactive", "unconfigured"]
"""When a parameter of a lifecycle node may change.

`always`, or while the node is `inactive` or unconfigured, or only while it is `unconfigured`.
"""

ValueT_co = TypeVar("ValueT_co", bound=ParameterValue, covariant=True)


class ParameterKind(Enum):
    """Type of a parameter; the value is its name in messages to the user."""

    BOOL = "true or false"
    INTEGER = "a whole number"
    DOUBLE = "a number"
    STRING = "text"
    BYTE_ARRAY = "bytes such as [0, 255]"
    BOOL_ARRAY = "booleans such as [true, false]"
    INTEGER_ARRAY = "whole numbers such as [1, 2]"
    DOUBLE_ARRAY = "numbers such as [1.0, 2.0]"
    STRING_ARRAY = "texts such as [a, b]"


@frozen
class SetParametersResult:
    """Result of setting parameters, with the fields of rcl_interfaces/SetParametersResult."""

    successful: bool
    reason: str = ""
    """Reason for a refusal."""


@frozen
class Parameter(Generic[ValueT_co]):
    """A declared parameter and its value, as rclpy's `get_parameter` gives it."""

    name: str
    value: ValueT_co


SCALARS = {
    ParameterKind.BOOL: bool,
    ParameterKind.INTEGER: int,
    ParameterKind.DOUBLE: float,
    ParameterKind.STRING: str,
}
"""Python type of each kind that is not an array."""

ELEMENTS = {
    ParameterKind.BOOL_ARRAY: ParameterKind.BOOL,
    ParameterKind.INTEGER_ARRAY: ParameterKind.INTEGER,
    ParameterKind.DOUBLE_ARRAY: ParameterKind.DOUBLE,
    ParameterKind.STRING_ARRAY: ParameterKind.STRING,
}
"""Kind of the elements of each array, except for bytes."""

_KIND_OF = {python_type: kind for kind, python_type in SCALARS.items()}
_ARRAY_OF = {
    bytes: ParameterKind.BYTE_ARRAY,
    **{SCALARS[element]: array for array, element in ELEMENTS.items()},
}


def _kind_of(spec: "ParameterSpec") -> ParameterKind:
    """Return the kind of a default.

    For a list its elements decide; a float among ints makes it double.
    """
    default: object = spec.default
    if isinstance(default, array.array):
        return _ARRAY_OF[float if default.typecode in "fd" else int]
    if isinstance(default, (bytes, bytearray)):
        return ParameterKind.BYTE_ARRAY
    if not isinstance(default, (list, tuple)):
        if type(default) not in _KIND_OF:
            raise TypeError(f"parameter {spec.name}: {default!r} is not a value of a parameter")
        return _KIND_OF[type(default)]
    types = {type(item) for item in default}
    if types == {int, float}:
        types = {float}
    if len(types) != 1 or not types <= _ARRAY_OF.keys():
        # An empty list says nothing, and a mixed one is none.
        raise TypeError(f"parameter {spec.name}: say which kind of array it is")
    return _ARRAY_OF[types.pop()]


@frozen
class ParameterSpec:
    """Description of a parameter: enough to declare it, to check a value and to explain it."""

    name: str
    default: ParameterValue
    description: str = ""
    # As a factory, and not by `@kind.default`, which pyright takes for no default at all.
    kind: ParameterKind = field(kw_only=True, default=Factory(_kind_of, takes_self=True))
    choices: tuple[str, ...] = field(kw_only=True, default=())
    """Allowed texts, if there is a choice."""
    minimum: float | None = field(kw_only=True, default=None)
    """Minimum; for arrays, of each element."""
    maximum: float | None = field(kw_only=True, default=None)
    """Maximum; for arrays, of each element."""
    read_only: bool = field(kw_only=True, default=False)
    """Whether the value cannot change after the declaration."""
    change_time: ChangeTime = field(
        kw_only=True, default="always", validator=validators.in_(get_args(ChangeTime))
    )
    """When the value may change. Only a lifecycle node can limit that."""
    general_name: str = field(kw_only=True, default="")
    """Name under which a value for every node is given from outside; empty if there is none.

    It counts if nothing is given under `name`. A manager sets it for `camera.fps` to `fps`.
    """
