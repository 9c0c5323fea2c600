"""Covariances of sensor_msgs and geometry_msgs, and the values that have a meaning of their own."""

from typing import TypeAlias

__all__ = ["COVARIANCE_NOT_REPORTED", "COVARIANCE_UNKNOWN", "Covariance"]

Covariance: TypeAlias = tuple[float, float, float, float, float, float, float, float, float]
"""A 3 x 3 matrix, row-major about x, y, z, in the squared unit of its quantity."""

COVARIANCE_UNKNOWN: Covariance = (0.0,) * 9
"""Covariance of a quantity whose accuracy is not known (sensor_msgs/Imu)."""

COVARIANCE_NOT_REPORTED: Covariance = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Covariance of a quantity that is not measured; its values mean nothing (sensor_msgs/Imu)."""
