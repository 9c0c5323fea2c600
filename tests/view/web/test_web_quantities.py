"""Numbers of a board: which are drawn, and which are absent."""

import math
from typing import Any

import pytest

from rosbase_view.web.quantities import (
    ACCELERATION,
    ANGULAR_VELOCITY,
    FIELD,
    IMU,
    MAGNETIC_FIELD,
    ORIENTATION,
    angles,
    quantities,
    rotation,
)
from support.viewing import imu

ABSENT = (-1.0, *(0.0,) * 8)


def test_a_rotation_is_a_unit_quaternion_with_w_first() -> None:
    turned = rotation(imu(90.0))
    assert turned == pytest.approx((math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
    assert turned is not None
    assert angles(turned) == pytest.approx((0.0, 0.0, 90.0))


def test_a_quaternion_of_another_length_is_made_a_unit_one() -> None:
    message = {**imu(), "orientation": {"x": 0.0, "y": 3.0, "z": 0.0, "w": 4.0}}
    assert rotation(message) == pytest.approx((0.8, 0.0, 0.6, 0.0))


@pytest.mark.parametrize("w", [0.0, math.nan, math.inf, 1e-9])
def test_a_quaternion_that_is_none_is_no_orientation(w: float) -> None:
    message = {**imu(), "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": w}}
    assert rotation(message) is None
    assert ORIENTATION not in quantities(IMU, message)


def test_what_the_covariance_says_is_absent_is_not_drawn() -> None:
    assert list(quantities(IMU, imu())) == [ORIENTATION, ANGULAR_VELOCITY, ACCELERATION]
    message: dict[str, Any] = {**imu(), "orientation_covariance": ABSENT}
    assert rotation(message) is None
    assert list(quantities(IMU, message)) == [ANGULAR_VELOCITY, ACCELERATION]
    message["angular_velocity_covariance"] = ABSENT
    assert quantities(IMU, message) == {ACCELERATION: (0.3, -0.1, 9.80665)}
    message["linear_acceleration_covariance"] = ABSENT
    assert quantities(IMU, message) == {}


def test_a_magnetic_field_is_in_microtesla() -> None:
    found = quantities(MAGNETIC_FIELD, {"magnetic_field": {"x": 2e-5, "y": 0.0, "z": -4.5e-5}})
    assert found[FIELD] == pytest.approx((20.0, 0.0, -45.0))


def test_other_messages_have_no_quantities() -> None:
    assert quantities("std_msgs/msg/Float64", {"data": 1.0}) == {}
