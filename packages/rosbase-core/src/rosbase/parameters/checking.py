"""Check values of parameters. A whole number is accepted for a double."""

import array
import difflib
import math
from collections.abc import Iterable
from typing import Any, cast

from rosbase.errors import ParameterError
from rosbase.parameters.kinds import (
    ELEMENTS,
    SCALARS,
    ParameterKind,
    ParameterSpec,
    ParameterValue,
)

__all__ = ["check_value", "did_you_mean"]

_INT64 = 2**63


def check_value(spec: ParameterSpec, value: object) -> ParameterValue:
    """Return the value as the parameter's own type.

    Raises:
        ParameterError: It is of another type, not finite, out of range or no choice. A text with a
            NUL is refused too, because neither the system nor ROS takes it.
    """
    checked = _as_kind(spec, value)
    for item in checked if isinstance(checked, list) else [checked]:
        if isinstance(item, str):
            if "\0" in item:
                raise ParameterError(f"parameter {spec.name} takes no NUL, as in {_shown(value)}")
        elif not isinstance(item, (bool, bytes)):
            _check_number(spec, item)
    items = checked if isinstance(checked, list) else [checked]
    if spec.choices and not all(item in spec.choices for item in items):
        raise ParameterError(
            f"parameter {spec.name} is one of {', '.join(spec.choices)}, not {_shown(value)}"
        )
    return checked


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return a hint for an unknown name, such as `; did you mean rate?`; empty if none."""
    near = difflib.get_close_matches(name, known, n=1)
    return f"; did you mean {near[0]}?" if near else ""


def _as_kind(spec: ParameterSpec, value: object) -> ParameterValue:
    if isinstance(value, array.array):
        value = value.tolist()
    if spec.kind is ParameterKind.BYTE_ARRAY:
        return _as_bytes(spec, value)
    element = ELEMENTS.get(spec.kind)
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


def _as_bytes(spec: ParameterSpec, value: Any) -> list[bytes]:
    if isinstance(value, (bytes, bytearray)):
        value = list(value)
    if not isinstance(value, (list, tuple)):
        raise _wrong_type(spec, value)
    found: list[bytes] = []
    for item in value:
        if isinstance(item, bytes) and len(item) == 1:
            found.append(item)
        elif _is_number(item) and isinstance(item, int) and 0 <= item <= 255:
            found.append(bytes((item,)))
        else:
            raise _wrong_type(spec, value)
    return found


def _as_scalar(spec: ParameterSpec, kind: ParameterKind, value: Any) -> bool | int | float | str:
    if kind is ParameterKind.DOUBLE and _is_number(value):
        return _to_float(spec, value)
    expected = SCALARS[kind]
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
    if isinstance(number, int) and not -_INT64 <= number < _INT64:
        raise ParameterError(f"parameter {spec.name} takes whole numbers of 64 bits")


def _wrong_type(spec: ParameterSpec, value: object) -> ParameterError:
    said = f"parameter {spec.name} takes {spec.kind.value}, not {_shown(value)}"
    kind = ELEMENTS.get(spec.kind, spec.kind)
    items = value if isinstance(value, (list, tuple)) else [value]
    if kind is ParameterKind.STRING and any(isinstance(item, (int, float)) for item in items):
        # A tool has taken a text for a number or a truth, and how it was written is lost.
        said += """; write text in quotes, in a shell as "'...'\""""
    return ParameterError(said)


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
