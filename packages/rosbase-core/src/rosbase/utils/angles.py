"""Angles within one turn."""

import math
from typing import Any, overload

from rosbase.utils.vectors import Maths, floats_of, is_array, maths_for

__all__ = ["warp2pi", "within_a_turn"]

_TURN = 2.0 * math.pi


@overload
def warp2pi(angle: float) -> float: ...
@overload
def warp2pi(angle: Any) -> Any: ...
def warp2pi(angle: Any) -> Any:
    """Return the same angle within one turn: above -pi, up to and including pi.

    Any number of turns is taken off. The result is exact: the remainder has no rounding.

    Args:
        angle: Radians; a number, or an array of numpy.

    Returns:
        A float, or an array of floats if an array is given.

    Raises:
        ValueError: A number is infinite or not a number, so that it is no angle.
        TypeError: It is complex.
    """
    maths = maths_for(angle)
    if not maths.are_finite(angle):
        raise ValueError(f"an angle is finite, not {angle}")
    return within_a_turn(floats_of(angle) if is_array(angle) else float(angle), maths)


def within_a_turn(angle: Any, maths: Maths) -> Any:
    """Return the angle above -pi, up to pi."""
    # `fmod` is exact, and so is the sum of numbers of the same size and opposite signs.
    rest = maths.fmod(angle, _TURN)
    rest = maths.choose(rest > math.pi, rest - _TURN, rest)
    return maths.choose(rest <= -math.pi, rest + _TURN, rest)
