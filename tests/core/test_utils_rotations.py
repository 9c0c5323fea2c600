"""Rotations of `rosbase.utils`, compared with transforms3d."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from transforms3d.euler import euler2mat, euler2quat
from transforms3d.quaternions import quat2mat

from rosbase.messages import Point, Quaternion, Vector3
from rosbase.utils import (
    VectorLPFilter,
    quat_rotate_inverse,
    quat_to_rpy,
    rpy_to_quat,
    trans_opt_to_ros_frame,
    trans_ros_frame_to_opt_frame,
    warp2pi,
)

ANGLES = st.floats(-10.0, 10.0)
QUARTERS = st.integers(-8, 8).map(lambda number: number * math.pi / 2)
NEAR_QUARTERS = st.tuples(QUARTERS, st.floats(-1e-6, 1e-6)).map(sum)
RPY = st.tuples(*[st.one_of(ANGLES, QUARTERS, NEAR_QUARTERS)] * 3)
LENGTHS = st.floats(1e-200, 1e200)
QUATERNIONS = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: max(map(abs, q)) > 1e-3)
VECTORS = st.tuples(*[st.floats(-100.0, 100.0)] * 3)


def same_rotation(one: Any, other: Any) -> bool:
    """Whether two unit quaternions turn in the same way: one may be the negative of the other."""
    return abs(abs(float(np.dot(one, other))) - 1.0) < 1e-12


@pytest.mark.parametrize("size", [1e308, 5e-324, 1.0])
def test_a_quaternion_of_any_finite_size_is_a_rotation(size: float) -> None:
    quarter = (math.pi / 2, 0.0, math.pi / 2)
    assert quat_to_rpy([size] * 4) == pytest.approx(quarter)
    assert np.allclose(quat_to_rpy(np.full((2, 4), size)), quarter)


@pytest.mark.parametrize("number", [math.nan, math.inf])
@pytest.mark.parametrize("place", range(4))
def test_a_quaternion_with_a_number_that_is_none_is_refused(number: float, place: int) -> None:
    quat = [1.0] * 4
    quat[place] = number
    for one in (quat, np.array([quat])):
        with pytest.raises(ValueError, match="a quaternion is finite"):
            quat_to_rpy(one)


@pytest.mark.parametrize("text", ["1000", b"1000"])
def test_a_text_is_no_vector(text: Any) -> None:
    for read in (quat_to_rpy, VectorLPFilter(0.1, 1.0, 4).update):
        with pytest.raises(TypeError, match="not the text"):
            read(text)


def test_complex_numbers_are_refused() -> None:
    for read in (warp2pi, quat_to_rpy, VectorLPFilter(0.1, 1.0, 4).update):
        with pytest.raises(TypeError, match="not complex ones"):
            read(np.array([1j, 0.0, 0.0, 0.0]))


@given(RPY)
def test_a_quaternion_is_that_of_the_library(rpy: tuple[float, ...]) -> None:
    assert np.allclose(rpy_to_quat(*rpy), euler2quat(*rpy), atol=1e-12)
    assert rpy_to_quat(rpy) == rpy_to_quat(*rpy)


@given(RPY, LENGTHS)
def test_the_angles_are_the_rotation_that_the_library_makes_of_the_quaternion(
    rpy: tuple[float, ...], length: float
) -> None:
    quat = euler2quat(*rpy)
    found = quat_to_rpy(tuple(length * quat))
    assert np.allclose(euler2mat(*found), quat2mat(quat), atol=1e-9)
    assert -math.pi / 2 <= found[1] <= math.pi / 2
    assert all(-math.pi < angle <= math.pi for angle in (found[0], found[2]))


@given(QUATERNIONS)
def test_there_and_back_is_the_same_rotation(quat: tuple[float, ...]) -> None:
    unit = np.array(quat) / np.linalg.norm(quat)
    assert same_rotation(rpy_to_quat(quat_to_rpy(quat)), unit)


@given(st.floats(-1.5, 1.5), st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_the_angles_are_those_that_the_quaternion_was_made_of(
    pitch: float, roll: float, yaw: float
) -> None:
    assert np.allclose(quat_to_rpy(rpy_to_quat(roll, pitch, yaw)), (roll, pitch, yaw), atol=1e-9)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
@given(ANGLES, ANGLES)
def test_a_quarter_turn_of_pitch_is_no_error_and_loses_nothing(
    pitch: float, roll: float, yaw: float
) -> None:
    quat = rpy_to_quat(roll, pitch, yaw)
    found = quat_to_rpy(quat)
    assert all(map(math.isfinite, found))
    assert found[1] == pytest.approx(pitch, abs=1e-7)
    assert same_rotation(rpy_to_quat(found), quat)


def test_an_exact_quarter_turn_has_exact_angles() -> None:
    assert quat_to_rpy((1.0, 0.0, 1.0, 0.0)) == (0.0, math.pi / 2, 0.0)
    assert quat_to_rpy((1.0, 0.0, -1.0, 0.0)) == (0.0, -math.pi / 2, 0.0)


@given(QUATERNIONS, VECTORS, LENGTHS)
def test_the_inverse_rotation_is_that_of_the_library(
    quat: tuple[float, ...], vector: tuple[float, ...], length: float
) -> None:
    expected = quat2mat(quat).T @ vector
    scaled = tuple(length * number for number in quat)
    assert np.allclose(quat_rotate_inverse(scaled, vector), expected, atol=1e-9)


def test_gravity_in_the_frame_of_a_body_that_has_pitched_up() -> None:
    # The nose points up, so gravity pulls backwards.
    found = quat_rotate_inverse(rpy_to_quat(0.0, -math.pi / 2, 0.0), (0.0, 0.0, -1.0))
    assert found == pytest.approx((-1.0, 0.0, 0.0))


@given(QUATERNIONS, VECTORS)
def test_the_order_of_ros_is_available_by_name(
    quat: tuple[float, float, float, float], vector: tuple[float, ...]
) -> None:
    w, x, y, z = quat
    message = Quaternion(x=x, y=y, z=z, w=w)
    for order in ("wxyz", "xyzw"):
        assert quat_to_rpy(message, order=order) == quat_to_rpy(quat)
    assert quat_to_rpy((x, y, z, w), order="xyzw") == quat_to_rpy(quat)
    expected = quat_rotate_inverse(quat, vector)
    assert quat_rotate_inverse((x, y, z, w), vector, order="xyzw") == expected
    assert quat_rotate_inverse(message, Vector3(*vector)) == expected
    w, x, y, z = rpy_to_quat(vector)
    assert rpy_to_quat(vector, order="xyzw") == (x, y, z, w)


def test_a_tuple_gives_a_tuple_and_an_array_an_array() -> None:
    for quat in ((1, 0, 0, 0), [1.0, 0.0, 0.0, 0.0], Quaternion(w=1.0)):
        assert quat_to_rpy(quat) == (0.0, 0.0, 0.0)
        assert quat_rotate_inverse(quat, Point(1.0, 2.0, 3.0)) == (1.0, 2.0, 3.0)
    found = quat_to_rpy(np.array([1, 0, 0, 0]))
    assert (found.shape, found.dtype) == ((3,), float)
    for quat, vector in ((np.eye(4)[0], (1, 2, 3)), ((1, 0, 0, 0), np.array([1, 2, 3]))):
        found = quat_rotate_inverse(quat, vector)
        assert isinstance(found, np.ndarray)
        assert found.tolist() == [1.0, 2.0, 3.0]
    assert rpy_to_quat(np.zeros(3)).tolist() == [1.0, 0.0, 0.0, 0.0]
    assert all(type(number) is float for number in rpy_to_quat(*np.zeros(3)))


@given(st.lists(st.tuples(QUATERNIONS, VECTORS), min_size=1, max_size=5))
def test_an_array_of_many_is_turned_at_once(many: list[Any]) -> None:
    quats, vectors = (np.array(part) for part in zip(*many, strict=True))
    each = [quat_rotate_inverse(quat, vector) for quat, vector in many]
    assert np.allclose(quat_rotate_inverse(quats, vectors), each)
    # One last digit decides between both ends of a turn, and they are the same rotation.
    for angles, (quat, _) in zip(quat_to_rpy(quats), many, strict=True):
        assert same_rotation(rpy_to_quat(angles), rpy_to_quat(quat_to_rpy(quat)))
    assert np.allclose(rpy_to_quat(vectors), [rpy_to_quat(vector) for _, vector in many])
    assert quat_rotate_inverse(quats, (0.0, 0.0, -1.0)).shape == (len(many), 3)


NOT_ROTATIONS: list[Any] = [
    (0.0, 0.0, 0.0, 0.0),
    (math.nan, 0.0, 0.0, 1.0),
    (math.inf, 0.0, 0.0, 1.0),
    (1.0, 0.0, 0.0),
    Quaternion(w=0.0),
    np.zeros(4),
    np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]]),
    np.array([[1.0, 0.0, 0.0, 0.0], [math.inf, 0.0, 0.0, 0.0]]),
    np.eye(3),
]


@pytest.mark.parametrize("quat", NOT_ROTATIONS, ids=repr)
def test_what_is_no_rotation_is_refused(quat: Any) -> None:
    with pytest.raises(ValueError, match=r"no rotation|takes 4 numbers"):
        quat_to_rpy(quat)
    with pytest.raises(ValueError, match=r"no rotation|takes 4 numbers"):
        quat_rotate_inverse(quat, (1.0, 2.0, 3.0))


def test_a_wrong_order_and_missing_or_infinite_angles_are_refused() -> None:
    wrong: Any = "zyxw"
    with pytest.raises(ValueError, match="wxyz or xyzw"):
        quat_to_rpy((1.0, 0.0, 0.0, 0.0), order=wrong)
    with pytest.raises(ValueError, match="wxyz or xyzw"):
        rpy_to_quat(0.0, 0.0, 0.0, order=wrong)
    with pytest.raises(ValueError, match="three angles"):
        rpy_to_quat(0.0, 0.0, None)
    with pytest.raises(ValueError, match="takes 3 numbers"):
        rpy_to_quat((0.0, 0.0))
    for angles in ((math.nan, 0.0, 0.0), np.array([0.0, math.inf, 0.0])):
        with pytest.raises(ValueError, match="finite"):
            rpy_to_quat(angles)


@given(st.floats(-math.pi, math.pi, exclude_min=True), st.integers(-10, 10))
def test_any_number_of_turns_is_taken_off(angle: float, turns: int) -> None:
    assert warp2pi(angle) == angle
    turned = warp2pi(angle + turns * 2 * math.pi)
    assert -math.pi < turned <= math.pi
    assert math.isclose(math.remainder(turned - angle, 2 * math.pi), 0.0, abs_tol=1e-12)


@given(st.floats(-1e300, 1e300))
def test_a_number_and_an_array_of_it_are_warped_alike_and_exactly(angle: float) -> None:
    found = warp2pi(angle)
    assert -math.pi < found <= math.pi
    # The standard library's is exact too, but has both ends.
    exact = math.remainder(angle, 2 * math.pi)
    assert found == (math.pi if exact == -math.pi else exact)
    assert warp2pi(np.array([[angle]])).tolist() == [[found]]


def test_the_ends_of_the_turn_and_what_is_no_angle() -> None:
    assert warp2pi(-math.pi) == warp2pi(math.pi) == math.pi
    assert warp2pi(np.arange(4)).dtype == float
    for angle in (math.nan, math.inf, np.array([0.0, math.nan])):
        with pytest.raises(ValueError, match="an angle is finite"):
            warp2pi(angle)


def test_the_optical_frame_has_x_to_the_right_y_down_and_z_forward() -> None:
    forward, left, up = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    assert trans_ros_frame_to_opt_frame(forward) == (0.0, 0.0, 1.0)
    assert trans_ros_frame_to_opt_frame(left) == (-1.0, 0.0, 0.0)
    assert trans_ros_frame_to_opt_frame(up) == (0.0, -1.0, 0.0)


@given(VECTORS)
def test_the_frames_of_a_camera_are_there_and_back(vector: tuple[float, ...]) -> None:
    there = trans_ros_frame_to_opt_frame(vector)
    assert trans_opt_to_ros_frame(there) == vector
    assert trans_ros_frame_to_opt_frame(Vector3(*vector)) == there
    many = trans_ros_frame_to_opt_frame(np.array([vector, vector]))
    assert many.tolist() == [list(there)] * 2
    assert trans_opt_to_ros_frame(many).tolist() == [list(vector)] * 2
