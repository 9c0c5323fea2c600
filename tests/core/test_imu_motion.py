"""The simulated motion is consistent: each quantity is the derivative of another."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.imu.motion import _EAST, _NORTH, _UP, motion_at
from rosbase.imu.simulator import payload_at
from rosbase.imu.units import STANDARD_GRAVITY
from rosbase.messages import Quaternion, Time

times = st.floats(0, 1000)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    return Quaternion(
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    )


def conjugate(q: Quaternion) -> Quaternion:
    return Quaternion(-q.x, -q.y, -q.z, q.w)


@given(times)
def test_the_orientation_is_a_unit_quaternion(t: float) -> None:
    q = motion_at(t).orientation
    assert math.hypot(q.x, q.y, q.z, q.w) == pytest.approx(1.0, abs=1e-12)


@given(times)
def test_body_rates_are_the_derivative_of_the_orientation(t: float) -> None:
    h = 1e-4
    before, after = motion_at(t - h).orientation, motion_at(t + h).orientation
    # For a small step the rotation between two orientations is half its angle in x, y, z.
    step = multiply(conjugate(before), after)
    rates = motion_at(t).angular_velocity
    for numeric, exact in zip((step.x, step.y, step.z), (rates.x, rates.y, rates.z), strict=True):
        assert numeric / h == pytest.approx(exact, abs=1e-4)


@given(times)
def test_specific_force_is_acceleration_and_gravity_in_the_body_frame(t: float) -> None:
    h = 1e-3
    q, f = motion_at(t).orientation, motion_at(t).linear_acceleration
    # Back to the world: q (f) q*.
    world = multiply(multiply(q, Quaternion(f.x, f.y, f.z, 0.0)), conjugate(q))
    for axis, swing, gravity in (
        ("x", _EAST, 0.0),
        ("y", _NORTH, 0.0),
        ("z", _UP, STANDARD_GRAVITY),
    ):
        second = (swing.value(t + h) - 2 * swing.value(t) + swing.value(t - h)) / h**2
        assert getattr(world, axis) - gravity == pytest.approx(second, abs=1e-3)


def test_the_motion_moves_every_axis() -> None:
    samples = [motion_at(t / 10) for t in range(300)]
    for quantity in ("angular_velocity", "linear_acceleration"):
        for axis in "xyz":
            values = [getattr(getattr(sample, quantity), axis) for sample in samples]
            assert max(values) - min(values) > 0.1


def test_a_payload_is_one_line_of_json_in_the_default_shape() -> None:
    line = payload_at(1.25, Time(1_700_000_000, 5))
    assert b"\n" not in line
    data = json.loads(line)
    sample = motion_at(1.25)
    assert data["header"] == {"stamp": {"sec": 1_700_000_000, "nanosec": 5}, "frame_id": "imu_link"}
    assert data["orientation"]["w"] == pytest.approx(sample.orientation.w, abs=1e-8)
    assert data["linear_acceleration"]["z"] == pytest.approx(sample.linear_acceleration.z, abs=1e-6)
