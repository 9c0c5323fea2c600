"""Read vectors as people have them: lists, tuples, arrays of numpy, and messages with x, y and z.

The core does not depend on numpy. An array shows that the program has imported it.
"""

import math
import sys
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, Protocol

from attrs import frozen

__all__ = [
    "Maths",
    "QuaternionMessage",
    "VectorMessage",
    "floats_of",
    "is_array",
    "maths_for",
    "numbers_of",
]


class VectorMessage(Protocol):
    """A message such as `Vector3` or `Point`, of rosbase or of ROS."""

    @property
    def x(self) -> float:
        """First number."""
        ...

    @property
    def y(self) -> float:
        """Second number."""
        ...

    @property
    def z(self) -> float:
        """Third number."""
        ...


class QuaternionMessage(VectorMessage, Protocol):
    """A message such as `Quaternion`, of rosbase or of ROS."""

    @property
    def w(self) -> float:
        """Real part."""
        ...


@frozen
class Maths:
    """Functions for floats, or the same ones for arrays."""

    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    fmod: Callable[[Any, Any], Any]
    hypot: Callable[[Any, Any], Any]
    atan2: Callable[[Any, Any], Any]
    are_finite: Callable[[Any], bool]
    least: Callable[[Any], float]
    choose: Callable[[Any, Any, Any], Any]
    """`choose(condition, one, other)`."""
    join: Callable[[Sequence[Any]], Any]
    """Makes a vector of its numbers: a tuple, or an array whose last axis is the vector."""


_FOR_FLOATS = Maths(
    math.sin,
    math.cos,
    math.fmod,
    math.hypot,
    math.atan2,
    math.isfinite,
    lambda number: number,
    lambda condition, one, other: one if condition else other,
    lambda numbers: tuple(map(float, numbers)),
)


def is_array(value: object) -> bool:
    """Return whether it is an array of numpy, without importing numpy."""
    numpy = sys.modules.get("numpy")
    return numpy is not None and isinstance(value, numpy.ndarray)


def maths_for(*values: object) -> Maths:
    """Return the functions for arrays if one of the values is an array, else those for floats."""
    return _for_arrays() if any(map(is_array, values)) else _FOR_FLOATS


@cache
def _for_arrays() -> Maths:
    numpy: Any = sys.modules["numpy"]
    return Maths(
        numpy.sin,
        numpy.cos,
        numpy.fmod,
        numpy.hypot,
        numpy.arctan2,
        lambda array: bool(numpy.isfinite(array).all()),
        lambda array: float(numpy.min(array, initial=math.inf)),
        numpy.where,
        lambda numbers: numpy.stack(numpy.broadcast_arrays(*numbers), axis=-1),
    )


def numbers_of(value: Any, names: str) -> tuple[Any, ...]:
    """Return the numbers of a vector one by one.

    Args:
        value: A sequence or a message, or an array whose last axis is the vector.
        names: Names of the numbers, in the order of a sequence, such as `xyz`.

    Returns:
        As many floats as names; of an array, as many arrays of floats.

    Raises:
        ValueError: It has another number of numbers.
        TypeError: It is a text, or has complex numbers.
    """
    if is_array(value):
        last = value.shape[-1] if value.shape else 0
        _check_length(last, names)
        return tuple(floats_of(value[..., index]) for index in range(len(names)))
    if all(hasattr(value, name) for name in names):
        return tuple(float(getattr(value, name)) for name in names)
    numbers: tuple[Any, ...] = floats_of(value)
    _check_length(len(numbers), names)
    return numbers


def floats_of(value: Any) -> Any:
    """Return an array of floats, or the numbers of a sequence as a tuple of them.

    Raises:
        TypeError: It is a text, whose characters could pass as numbers, or has complex numbers.
    """
    if is_array(value):
        if value.dtype.kind == "c":
            raise TypeError("takes real numbers, not complex ones")
        return value.astype(float)
    if isinstance(value, (str, bytes, bytearray)):
        raise TypeError(f"takes numbers, not the text {value!r}")
    return tuple(map(float, value))


def _check_length(length: int, names: str) -> None:
    if length != len(names):
        raise ValueError(f"takes {len(names)} numbers ({' '.join(names)}), not {length}")
