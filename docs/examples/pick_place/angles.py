"""Headings and the quaternions that messages carry them in."""

import math

from rosbase.messages import Quaternion


def quaternion_of(yaw_rad: float) -> Quaternion:
    """The rotation by that heading, counter-clockwise."""
    return Quaternion(z=math.sin(yaw_rad / 2), w=math.cos(yaw_rad / 2))


def yaw_of(rotation: Quaternion) -> float:
    """The heading of something that stands upright, in rad."""
    return 2 * math.atan2(rotation.z, rotation.w)
