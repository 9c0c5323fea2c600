"""Quaternions: whether four numbers are a rotation."""

import math
from collections.abc import Callable

from rosbase.mapping.quantities import Numbers
from rosbase.mapping.rejects import Reject

__all__ = ["compile_unit_quaternion"]

# Nearer to 1 than this is what rounding leaves, and is published as it was reported.
_ROUNDING = 1e-6

# The square of a norm that is surely so near, without taking its root.
_SURELY = 1.9e-6


def compile_unit_quaternion(tolerance: float) -> Callable[[Numbers], Numbers | Reject]:
    """Return a function that gives a quaternion norm 1, if it was within `tolerance` of it."""

    def finish(numbers: Numbers) -> Numbers | Reject:
        x, y, z, w = numbers
        if -_SURELY < x * x + y * y + z * z + w * w - 1.0 < _SURELY:
            return numbers
        norm = math.hypot(*numbers)
        error = abs(norm - 1.0)
        if error <= _ROUNDING:
            return numbers
        if error <= tolerance:
            return tuple([number / norm for number in numbers])
        return Reject("bad_quaternion", f"norm {norm:.6g}")

    return finish
