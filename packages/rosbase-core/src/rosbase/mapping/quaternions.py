"""Check and normalise quaternions."""

import math
from collections.abc import Callable

from rosbase.mapping.quantities import Numbers
from rosbase.mapping.rejects import Reject

__all__ = ["compile_unit_quaternion"]

# A norm that differs less than this from 1 was rounded: the quaternion is published as it is.
_ROUNDING = 1e-6

# If the square of the norm differs less than this from 1, the norm is within the rounding.
_SURELY = 1.9e-6


def compile_unit_quaternion(tolerance: float) -> Callable[[Numbers], Numbers | Reject]:
    """Return a function that normalises a quaternion whose norm is within `tolerance` of 1."""

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
