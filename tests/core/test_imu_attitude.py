"""Angles for people to read, from a quaternion."""

from math import isclose, pi

from hypothesis import given
from hypothesis import strategies as st

from rosbase.imu.attitude import roll_pitch_yaw
from rosbase.imu.motion import _quaternion
from rosbase.messages import Quaternion

HALF_TURNS = st.floats(-pi + 1e-6, pi - 1e-6)


@given(HALF_TURNS, st.floats(-1.57, 1.57), HALF_TURNS, st.floats(0.5, 2.0))
def test_the_angles_are_those_that_the_quaternion_was_made_of(
    roll: float, pitch: float, yaw: float, norm: float
) -> None:
    q = _quaternion(roll, pitch, yaw)
    scaled = Quaternion(norm * q.x, norm * q.y, norm * q.z, norm * q.w)
    for found, made in zip(roll_pitch_yaw(scaled), (roll, pitch, yaw), strict=True):
        assert isclose(found, made, abs_tol=1e-4)


def test_a_quarter_turn_upwards_is_no_error() -> None:
    q = _quaternion(0.0, pi / 2, 0.0)
    assert isclose(roll_pitch_yaw(q)[1], pi / 2, abs_tol=1e-6)
