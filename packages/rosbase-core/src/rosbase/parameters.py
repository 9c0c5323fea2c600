"""Parameters: what they are called, of which type they are, and which values they take.

The types are those of rcl_interfaces/ParameterType. A whole number is accepted where a
double is due; nothing else is converted.
"""

import difflib
import math
import re
from collections.abc import Iterable
from enum import Enum
from typing import Any, TypeAlias, cast

from attrs import field, frozen

from rosbase.errors import ParameterError

__all__ = [
    "Parameter",
    "ParameterKind",
    "ParameterSpec",
    "ParameterValue",
    "SetParametersResult",
    "check_value",
    "did_you_mean",
    "parse_text",
]

ParameterValue: TypeAlias = (
    bool | int | float | str | list[bool] | list[int] | list[float] | list[str]
)
"""What a parameter can be."""


class ParameterKind(Enum):
    """The type of a parameter; the value is how it is called in a message to the user."""

    BOOL = "true or false"
    INTEGER = "a whole number"
    DOUBLE = "a number"
    STRING = "text"
    BOOL_ARRAY = "truths such as [true, false]"
    INTEGER_ARRAY = "whole numbers such as [1, 2]"
    DOUBLE_ARRAY = "numbers such as [1.0, 2.0]"
    STRING_ARRAY = "texts such as [a, b]"


@frozen
class SetParametersResult:
    """Whether parameters were set; the fields are those of rcl_interfaces/SetParametersResult."""

    successful: bool
    reason: str = ""
    """Why they were not."""


@frozen
class Parameter:
    """A declared parameter and its value, as rclpy's `get_parameter` gives it."""

    name: str
    value: ParameterValue


_SCALARS = {
    bool: ParameterKind.BOOL,
    int: ParameterKind.INTEGER,
    float: ParameterKind.DOUBLE,
    str: ParameterKind.STRING,
}
_ARRAYS = {
    bool: ParameterKind.BOOL_ARRAY,
    int: ParameterKind.INTEGER_ARRAY,
    float: ParameterKind.DOUBLE_ARRAY,
    str: ParameterKind.STRING_ARRAY,
}
_ELEMENTS = {array: _SCALARS[element] for element, array in _ARRAYS.items()}


def _kind_of(spec: "ParameterSpec") -> ParameterKind:
    """The kind that a default says: of a list, by its elements; a float among ints is one."""
    default = spec.default
    if not isinstance(default, (list, tuple)):
        if type(default) not in _SCALARS:
            raise TypeError(f"parameter {spec.name}: {default!r} is not a value of a parameter")
        return _SCALARS[type(default)]
    types = {type(item) for item in default}
    if types == {int, float}:
        types = {float}
    if len(types) != 1 or not types <= _ARRAYS.keys():
        # An empty list says nothing, and a mixed one is none.
        raise TypeError(f"parameter {spec.name}: say which kind of array it is")
    return _ARRAYS[types.pop()]


@frozen
class ParameterSpec:
    """What a parameter is: enough to declare it, to check a value and to explain it."""

    name: str
    default: ParameterValue
    description: str = ""
    kind: ParameterKind = field(kw_only=True)
    choices: tuple[str, ...] = field(kw_only=True, default=())
    """The only texts allowed, if there are any here."""
    minimum: float | None = field(kw_only=True, default=None)
    """The least number allowed; for arrays, of each element."""
    maximum: float | None = field(kw_only=True, default=None)
    """The greatest number allowed; for arrays, of each element."""
    read_only: bool = field(kw_only=True, default=False)
    """Whether its value stays what it was when it was declared."""

    @kind.default
    def _default_kind(self) -> ParameterKind:
        return _kind_of(self)


def check_value(spec: ParameterSpec, value: object) -> ParameterValue:
    """The value as the parameter's own type.

    Raises:
        ParameterError: It is of another type, not finite, out of range, no choice, or a text
            with a NUL, which neither the system nor ROS takes.
    """
    checked = _as_kind(spec, value)
    for item in checked if isinstance(checked, list) else [checked]:
        if isinstance(item, str):
            if "\0" in item:
                raise ParameterError(f"parameter {spec.name} takes no NUL, as in {_shown(value)}")
        elif not isinstance(item, bool):
            _check_number(spec, item)
    if spec.choices and checked not in spec.choices:
        raise ParameterError(
            f"parameter {spec.name} is one of {', '.join(spec.choices)}, not {_shown(value)}"
        )
    return checked


def parse_text(spec: ParameterSpec, text: str) -> ParameterValue:
    """The value that a user wrote for the parameter, as in `-p name:=text`.

    Raises:
        ParameterError: The text does not say a value of the parameter's type.
    """
    match spec.kind:
        case ParameterKind.STRING:
            return check_value(spec, text)
        case ParameterKind.STRING_ARRAY:
            return check_value(spec, _items(text))
        case ParameterKind.BOOL_ARRAY | ParameterKind.INTEGER_ARRAY | ParameterKind.DOUBLE_ARRAY:
            return check_value(spec, [_scalar(item) for item in _items(text)])
    return check_value(spec, _scalar(text))


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a hint for a name that is not known, such as `; did you mean rate?`; empty if none."""
    near = difflib.get_close_matches(name, known, n=1)
    return f"; did you mean {near[0]}?" if near else ""


_INTEGER = re.compile(r"[-+]?\d+", re.ASCII)
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)

# One pair of quotes around a whole item.
_QUOTED = re.compile(r"^([\"'])((?:(?!\1).)*)\1$", re.DOTALL)


def _scalar(text: str) -> bool | int | float | str:
    text = text.strip()
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    # Longer numbers mean nothing here, and Python refuses to convert some of them.
    if len(text) < 400:
        if _INTEGER.fullmatch(text):
            return int(text)
        if _NUMBER.fullmatch(text):
            return float(text)
    return text


def _items(text: str) -> list[str]:
    """Split a list such as `[a, 'b, c', d[0, 1]]` at commas outside quotes and inner brackets."""
    pieces = _pieces(text)
    if len(pieces) == 1 and _closes_last(pieces[0]):
        pieces = _pieces(pieces[0][1:-1])
    return [_QUOTED.sub(r"\2", piece) for piece in pieces if piece]


def _pieces(text: str) -> list[str]:
    pieces, depth, quote = [""], 0, ""
    for sign in text:
        if quote:
            quote = "" if sign == quote else quote
        elif sign == '"' or (sign == "'" and not pieces[-1].strip()):
            # An apostrophe may also stand within a text.
            quote = sign
        else:
            depth += (sign == "[") - (sign == "]")
        if sign == "," and not quote and depth <= 0:
            pieces.append("")
        else:
            pieces[-1] += sign
    return [piece.strip() for piece in pieces]


def _closes_last(text: str) -> bool:
    """Whether the bracket that opens a text is closed by the one that ends it."""
    depth = 0
    for at, sign in enumerate(text):
        depth += (sign == "[") - (sign == "]")
        if depth <= 0:
            return at > 0 and at == len(text) - 1
    return False


def _as_kind(spec: ParameterSpec, value: object) -> ParameterValue:
    element = _ELEMENTS.get(spec.kind)
    if element is None:
        return _as_scalar(spec, spec.kind, value)
    if spec.kind is ParameterKind.DOUBLE_ARRAY and _is_number(value):
        value = [value]
    if not isinstance(value, (list, tuple)):
        raise _wrong_type(spec, value)
    try:
        items: Any = [_as_scalar(spec, element, item) for item in value]
    except ParameterError as error:
        raise error if "large" in str(error) else _wrong_type(spec, value) from None
    return list(items)


def _as_scalar(spec: ParameterSpec, kind: ParameterKind, value: Any) -> bool | int | float | str:
    if kind is ParameterKind.DOUBLE and _is_number(value):
        return _to_float(spec, value)
    expected: type = {kind: of for of, kind in _SCALARS.items()}[kind]
    if isinstance(value, expected) and (expected is bool or not isinstance(value, bool)):
        return cast("bool | int | float | str", value)
    raise _wrong_type(spec, value)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _to_float(spec: ParameterSpec, value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise ParameterError(f"parameter {spec.name} is too large a number") from None


def _check_number(spec: ParameterSpec, number: float) -> None:
    if isinstance(number, float) and not math.isfinite(number):
        raise ParameterError(f"parameter {spec.name} must be finite, not {number}")
    if spec.minimum is not None and number < spec.minimum:
        raise ParameterError(
            f"parameter {spec.name} is at least {spec.minimum:g}, not {_shown(number)}"
        )
    if spec.maximum is not None and number > spec.maximum:
        raise ParameterError(
            f"parameter {spec.name} is at most {spec.maximum:g}, not {_shown(number)}"
        )


def _wrong_type(spec: ParameterSpec, value: object) -> ParameterError:
    return ParameterError(f"parameter {spec.name} takes {spec.kind.value}, not {_shown(value)}")


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
