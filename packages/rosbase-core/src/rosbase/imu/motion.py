"""A rigid motion in closed form, and the measurements of an ideal IMU on it at any time.

Orientation, rates and specific force are derivatives of one motion, so that they agree with each
other as in a real device.

Frames and signs: REP-103 (world ENU, body x forward, y left, z up). Kinematics of the
angles yaw, pitch, roll about z, y', x'': Diebel, "Representing Attitude", 2006, eq. 72
and following.
"""

from math import cos, pi, sin

from attrs import frozen

from rosbase.imu.units import STANDARD_GRAVITY
from rosbase.messages import Quaternion, Vector3

__all__ = ["MotionSample", "motion_at"]


@frozen
class MotionSample:
    """Measurement of an ideal IMU at one instant."""

    orientation: Quaternion
    """Orientation of the body in the world frame."""
    angular_velocity: Vector3
    """rad/s, in the body frame."""
    linear_acceleration: Vector3
    """Specific force in m/s^2, in the body frame: gravity shows as +9.81 upwards."""


@frozen
class _Swing:
    """Oscillation x(t) = amplitude * sin(2 pi f t)."""

    amplitude: float
    frequency_hz: float

    def value(self, t: float) -> float:
        return self.amplitude * sin(self._w * t)

    def rate(self, t: float) -> float:
        return self.amplitude * self._w * cos(self._w * t)

    def acceleration(self, t: float) -> float:
        return -self.amplitude * self._w**2 * sin(self._w * t)

    @property
    def _w(self) -> float:
        return 2.0 * pi * self.frequency_hz


# A hand that turns the board over a desk: angles in rad, positions in m.
_ROLL, _PITCH, _YAW = _Swing(0.35, 0.31), _Swing(0.25, 0.23), _Swing(1.2, 0.07)
_EAST, _NORTH, _UP = _Swing(0.10, 0.29), _Swing(0.08, 0.37), _Swing(0.05, 0.43)


def motion_at(t: float) -> MotionSample:
    """Return the ideal measurement at `t` seconds."""
    roll, pitch, yaw = _ROLL.value(t), _PITCH.value(t), _YAW.value(t)
    orientation = _quaternion(roll, pitch, yaw)
    force = Vector3(
        _EAST.acceleration(t), _NORTH.acceleration(t), _UP.acceleration(t) + STANDARD_GRAVITY
    )
    return MotionSample(orientation, _body_rates(t, roll, pitch), _to_body(orientation, force))


def _quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    cr, sr = cos(roll / 2), sin(roll / 2)
    cp, sp = cos(pitch / 2), sin(pitch / 2)
    cy, sy = cos(yaw / 2), sin(yaw / 2)
    return Quaternion(
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
        w=cr * cp * cy + sr * sp * sy,
    )


def _body_rates(t: float, roll: float, pitch: float) -> Vector3:
    roll_rate, pitch_rate, yaw_rate = _ROLL.rate(t), _PITCH.rate(t), _YAW.rate(t)
    return Vector3(
        roll_rate - yaw_rate * sin(pitch),
        pitch_rate * cos(roll) + yaw_rate * sin(roll) * cos(pitch),
        -pitch_rate * sin(roll) + yaw_rate * cos(roll) * cos(pitch),
    )


def _to_body(q: Quaternion, v: Vector3) -> Vector3:
    """Return the world vector in the body frame: the transposed rotation matrix of q, times v."""
    x, y, z, w = q.x, q.y, q.z, q.w
    return Vector3(
        (1 - 2 * (y * y + z * z)) * v.x + 2 * (x * y + w * z) * v.y + 2 * (x * z - w * y) * v.z,
        2 * (x * y - w * z) * v.x + (1 - 2 * (x * x + z * z)) * v.y + 2 * (y * z + w * x) * v.z,
        2 * (x * z + w * y) * v.x + 2 * (y * z - w * x) * v.y + (1 - 2 * (x * x + y * y)) * v.z,
    )
