"""Rotations: quaternions, and roll, pitch and yaw.

Programs written for ros_base have quaternions w x y z. ROS has x y z w: say so with
`order="xyzw"`. Messages have names for their numbers, so the order does not matter to them.
"""

import math
from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, overload

from rosbase.utils.angles import within_a_turn
from rosbase.utils.vectors import (
    QuaternionMessage,
    VectorMessage,
    maths_for,
    numbers_of,
)

__all__ = ["Order", "quat_rotate_inverse", "quat_to_rpy", "rpy_to_quat"]

Order: TypeAlias = Literal["wxyz", "xyzw"]
_ORDERS = ("wxyz", "xyzw")


@overload
def quat_to_rpy(
    quat: Sequence[float] | QuaternionMessage, *, order: Order = "wxyz"
) -> tuple[float, float, float]: ...
@overload
def quat_to_rpy(quat: Any, *, order: Order = "wxyz") -> Any: ...
def quat_to_rpy(quat: Any, *, order: Order = "wxyz") -> Any:
    """Return roll, pitch and yaw of a quaternion of any length but 0.

    They are rotations about the fixed axes x, y and z, in this order; the same as yaw, pitch and
    roll about the moving axes (REP-103). Pitch is from -pi/2 to pi/2; roll and yaw are above -pi,
    up to pi. At a pitch of a quarter turn, many pairs of roll and yaw are the same rotation: the
    result is one of them. See Bernardes and Viollet, "Quaternion to Euler angles conversion: A
    direct, general and computationally efficient method", 2022.

    Args:
        quat: A list, a tuple, a `Quaternion` message, or an array of numpy whose last axis is the
            quaternion.
        order: `wxyz`, or `xyzw` as in ROS, of a list, tuple or array.

    Returns:
        A tuple of radians, or an array if an array is given.

    Raises:
        ValueError: There are not four numbers, or they are all 0, or one is not finite.
    """
    maths = maths_for(quat)
    w, x, y, z = _scaled(quat, order)
    half_sum, half_difference = maths.atan2(x + z, w - y), maths.atan2(x - z, w + y)
    up, down = maths.hypot(w + y, x - z), maths.hypot(w - y, x + z)
    pitch = 2.0 * maths.atan2(up, down) - math.pi / 2.0
    roll, yaw = half_sum + half_difference, half_sum - half_difference
    return maths.join((within_a_turn(roll, maths), pitch, within_a_turn(yaw, maths)))


@overload
def rpy_to_quat(
    roll: float, pitch: float, yaw: float, *, order: Order = "wxyz"
) -> tuple[float, float, float, float]: ...
@overload
def rpy_to_quat(
    roll: Sequence[float], *, order: Order = "wxyz"
) -> tuple[float, float, float, float]: ...
@overload
def rpy_to_quat(roll: Any, pitch: Any = None, yaw: Any = None, *, order: Order = "wxyz") -> Any: ...
def rpy_to_quat(roll: Any, pitch: Any = None, yaw: Any = None, *, order: Order = "wxyz") -> Any:
    """Return the unit quaternion of roll, pitch and yaw, as `quat_to_rpy` defines them.

    Args:
        roll: Radians; or all three angles, as a list, a tuple or an array whose last axis they are.
        pitch: Radians, if `roll` is one angle.
        yaw: Radians, if `roll` is one angle.
        order: `wxyz`, or `xyzw` as in ROS, of the result.

    Returns:
        A tuple, or an array if an array is given.

    Raises:
        ValueError: There are not three angles, or one is not finite.
    """
    if (pitch is None) is not (yaw is None):
        raise ValueError("rpy_to_quat takes three angles, or one vector of three")
    maths = maths_for(roll, pitch, yaw)
    angles = numbers_of(roll, "rpy") if pitch is None else (roll, pitch, yaw)
    if not all(map(maths.are_finite, angles)):
        raise ValueError(f"angles are finite, not {angles}")
    halves = [0.5 * angle for angle in angles]
    (cr, cp, cy), (sr, sp, sy) = map(maths.cos, halves), map(maths.sin, halves)
    numbers = {
        "w": cr * cp * cy + sr * sp * sy,
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
    }
    return maths.join([numbers[name] for name in _checked(order)])


@overload
def quat_rotate_inverse(
    quat: Sequence[float] | QuaternionMessage,
    vector: Sequence[float] | VectorMessage,
    *,
    order: Order = "wxyz",
) -> tuple[float, float, float]: ...
@overload
def quat_rotate_inverse(quat: Any, vector: Any, *, order: Order = "wxyz") -> Any: ...
def quat_rotate_inverse(quat: Any, vector: Any, *, order: Order = "wxyz") -> Any:
    """Return a vector turned by the inverse of a rotation: from the world's frame to the body's.

    Args:
        quat: Orientation of the body, of any length but 0: a list, a tuple, a `Quaternion` message,
            or an array of numpy whose last axis is the quaternion.
        vector: A list, a tuple, a message such as `Vector3`, or an array whose last axis is the
            vector.
        order: `wxyz`, or `xyzw` as in ROS, of a list, tuple or array.

    Returns:
        A tuple, or an array if one of the two is an array.

    Raises:
        ValueError: The quaternion has not four numbers, or they are all 0, or one is not finite.
            Or the vector has not three.
    """
    w, x, y, z = _scaled(quat, order)
    a, b, c = numbers_of(vector, "xyz")
    twice = 2.0 / (w * w + x * x + y * y + z * z)
    # The cross product of the imaginary part and the vector, once and once more.
    p, q, r = y * c - z * b, z * a - x * c, x * b - y * a
    return maths_for(quat, vector).join(
        (
            a + twice * (y * r - z * q - w * p),
            b + twice * (z * p - x * r - w * q),
            c + twice * (x * q - y * p - w * r),
        )
    )


def _checked(order: str) -> str:
    if order not in _ORDERS:
        raise ValueError(f"the order of a quaternion is wxyz or xyzw, not {order!r}")
    return order


def _scaled(quat: Any, order: str) -> tuple[Any, Any, Any, Any]:
    """Return w, x, y, z of a size whose squares are neither too large nor too small."""
    numbers = dict(zip(order, numbers_of(quat, _checked(order)), strict=True))
    maths = maths_for(quat)
    w, x, y, z = (numbers[name] for name in "wxyz")
    # The largest one: a sum of them could be too large for a float.
    size = abs(w)
    for number in (x, y, z):
        size = maths.choose(abs(number) > size, abs(number), size)
    if not (maths.least(size) > 0.0 and all(map(maths.are_finite, (w, x, y, z)))):
        raise ValueError(f"no rotation: a quaternion is finite and not 0, but is {quat}")
    return w / size, x / size, y / size, z / size
