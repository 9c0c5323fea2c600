"""Numbers of a board that are drawn: its orientation, and the curves of its quantities. Pure."""

import math
from collections.abc import Mapping
from typing import Any, TypeAlias

from attrs import frozen

from rosbase.utils import quat_to_rpy

__all__ = [
    "IMU",
    "MAGNETIC_FIELD",
    "QUANTITIES",
    "Quantity",
    "Rotation",
    "angles",
    "quantities",
    "rotation",
]

IMU = "sensor_msgs/msg/Imu"
MAGNETIC_FIELD = "sensor_msgs/msg/MagneticField"

Rotation: TypeAlias = tuple[float, float, float, float]
"""Unit quaternion w, x, y, z: from the sensor's frame to the world's."""
Values: TypeAlias = tuple[float, ...]

_LEAST_NORM = 1e-6
_MICRO = 1e6


@frozen
class Quantity:
    """Something that a board measures: a curve for each of its names, in one plot."""

    title: str
    unit: str
    least: float
    """The plot reaches from minus this to this at least, so that noise does not fill it."""
    names: tuple[str, ...] = ("x", "y", "z")


ORIENTATION = Quantity("orientation", "°", 10.0, ("roll", "pitch", "yaw"))
ANGULAR_VELOCITY = Quantity("angular velocity", "rad/s", 0.5)
ACCELERATION = Quantity("acceleration", "m/s²", 2.0)
FIELD = Quantity("magnetic field", "µT", 10.0)
QUANTITIES = (ORIENTATION, ANGULAR_VELOCITY, ACCELERATION, FIELD)
"""All of them, in the order of their plots."""


def rotation(message: Mapping[str, Any]) -> Rotation | None:
    """Return the orientation of an Imu; None if the message has none.

    A first element of -1 in the covariance says that there is none (sensor_msgs/Imu).
    """
    if _is_absent(message, "orientation_covariance"):
        return None
    found = message["orientation"]
    numbers = found["w"], found["x"], found["y"], found["z"]
    norm = math.hypot(*numbers)
    # Neither 0, as of a message that nobody has filled in, nor infinite or NaN.
    if not _LEAST_NORM < norm < math.inf:
        return None
    w, x, y, z = (number / norm for number in numbers)
    return w, x, y, z


def angles(turned: Rotation) -> Values:
    """Return roll, pitch and yaw in degrees."""
    # Without a sign for what is 0 but for rounding.
    return tuple(round(math.degrees(angle), 3) + 0.0 for angle in quat_to_rpy(turned))


def quantities(type_name: str, message: Mapping[str, Any]) -> dict[Quantity, Values]:
    """Return the quantities that a message has.

    Args:
        type_name: ROS type of the message.
        message: Its fields by name, as `rosbase.wire.plain` reads them.
    """
    if type_name == MAGNETIC_FIELD:
        return {FIELD: tuple(axis * _MICRO for axis in _vector(message["magnetic_field"]))}
    if type_name != IMU:
        return {}
    found: dict[Quantity, Values] = {}
    turned = rotation(message)
    if turned is not None:
        found[ORIENTATION] = angles(turned)
    if not _is_absent(message, "angular_velocity_covariance"):
        found[ANGULAR_VELOCITY] = _vector(message["angular_velocity"])
    if not _is_absent(message, "linear_acceleration_covariance"):
        found[ACCELERATION] = _vector(message["linear_acceleration"])
    return found


def _is_absent(message: Mapping[str, Any], covariance: str) -> bool:
    return bool(message[covariance][0] == -1.0)


def _vector(fields: Mapping[str, float]) -> Values:
    return fields["x"], fields["y"], fields["z"]
