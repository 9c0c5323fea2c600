"""Heading and roll, and the quaternions that messages carry them in."""

import math

from rosbase.messages import Quaternion


def quaternion_of(roll_rad: float, yaw_rad: float) -> Quaternion:
    """Rolled to the right by the one angle, then turned to the left by the other."""
    sr, cr = math.sin(roll_rad / 2), math.cos(roll_rad / 2)
    sy, cy = math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)
    return Quaternion(x=cy * sr, y=sy * sr, z=sy * cr, w=cy * cr)


def roll_of(q: Quaternion) -> float:
    """How far something leans to its right, in rad."""
    return math.atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x**2 + q.y**2))


def yaw_of(q: Quaternion) -> float:
    """The heading of something, in rad, counter-clockwise."""
    return math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2))
