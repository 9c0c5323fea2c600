"""Gravity's direction: what turns the orientation round is found at rest, and nothing else is."""

import math
from collections.abc import Callable, Sequence
from random import Random
from typing import TypeAlias

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rosbase.imu.checks.direction import GravityDirection
from rosbase.imu.checks.window import WINDOW, summarise
from rosbase.imu.motion import motion_at
from support.strategies import unit_quaternions
from support.windows import LEVEL, sample_of, window_of

S = 1_000_000_000
G = 9.80665
Vector: TypeAlias = tuple[float, ...]
Mistake: TypeAlias = Callable[[Vector, Vector], tuple[Vector, Vector]]


def up_in_body(q: Vector) -> Vector:
    """The direction upwards, as the sensor sees it: the last row of the rotation matrix."""
    x, y, z, w = q
    return (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))


def angle_to_up(q: Vector, f: Vector) -> float:
    cosine = sum(a * b for a, b in zip(up_in_body(q), f, strict=True)) / math.hypot(*f)
    return math.degrees(math.acos(max(-1.0, min(1.0, cosine))))


def rest(
    check: GravityDirection,
    q: Vector,
    f: Vector,
    *,
    windows: int = 4,
    noise: float = 0.0,
    seed: int = 1,
    since_s: float = 0.0,
) -> str:
    """What is found when the sensor rests for a second in each window."""
    draw = Random(seed)
    for number in range(windows):
        noisy = [tuple(axis + draw.gauss(0.0, noise) for axis in f) for _ in range(WINDOW)]
        began_ns = round((since_s + number) * S)
        check.judge(window_of(noisy, q, began_ns, began_ns + S))
    return check.finding


def swapped(q: Vector, f: Vector) -> tuple[Vector, Vector]:
    """A quaternion sent as w, x, y, z and read as x, y, z, w."""
    return (q[3], q[0], q[1], q[2]), f


def swapped_the_other_way(q: Vector, f: Vector) -> tuple[Vector, Vector]:
    """A quaternion sent as x, y, z, w and read as w, x, y, z."""
    return (q[1], q[2], q[3], q[0]), f


def inverse(q: Vector, f: Vector) -> tuple[Vector, Vector]:
    return (-q[0], -q[1], -q[2], q[3]), f


def gravity_instead_of_force(q: Vector, f: Vector) -> tuple[Vector, Vector]:
    return q, (-f[0], -f[1], -f[2])


def orientation_of_ned(q: Vector, f: Vector) -> tuple[Vector, Vector]:
    """From NED to FRD: in both frames north, or x, is as it was, and y and z turn round.

    The world's x and y are exchanged as well, which is a turn about the vertical.
    """
    return (q[0], -q[1], -q[2], q[3]), f


def x_inverted(q: Vector, f: Vector) -> tuple[Vector, Vector]:
    return q, (-f[0], f[1], f[2])


def exchanged(q: Vector, f: Vector) -> tuple[Vector, Vector]:
    return q, (f[1], f[0], f[2])


MISTAKES: dict[str, tuple[Mistake, str, str]] = {
    "wxyz read as xyzw": (swapped, "xyzw", "is mapping.orientation.order wxyz, not xyzw?"),
    "xyzw read as wxyz": (
        swapped_the_other_way,
        "wxyz",
        "is mapping.orientation.order xyzw, not wxyz?",
    ),
    "the inverse": (inverse, "xyzw", "is it the inverse"),
    "gravity instead of force": (gravity_instead_of_force, "xyzw", "does z point down (NED)"),
    "NED to FRD": (orientation_of_ned, "xyzw", "is the orientation from NED to FRD"),
    "x inverted": (x_inverted, "xyzw", "has the x axis of one the wrong sign"),
    "x and y exchanged": (exchanged, "xyzw", "are the x and y axes of one exchanged"),
}


@given(unit_quaternions, st.floats(0.0, 0.06), st.integers(0, 1000))
def test_whatever_the_orientation_a_right_one_is_never_found_fault_with(
    q: Vector, noise: float, seed: int
) -> None:
    force = tuple(G * axis for axis in up_in_body(q))
    assert rest(GravityDirection(), q, force, noise=noise, seed=seed) == ""


@given(unit_quaternions, st.floats(0.0, 2.0 * math.pi), st.floats(0.0, 15.0))
def test_neither_yaw_nor_an_error_of_fifteen_degrees_is_found_fault_with(
    q: Vector, yaw: float, error_deg: float
) -> None:
    tilt = math.radians(error_deg) / 2.0
    x, y, z, w = q
    # Turned about the world's z, which is any yaw; then tilted about the body's x.
    cz, sz = math.cos(yaw), math.sin(yaw)
    turned = (cz * x - sz * y, cz * y + sz * x, cz * z + sz * w, cz * w - sz * z)
    x, y, z, w = turned
    c, s = math.cos(tilt), math.sin(tilt)
    tilted = (c * x + s * w, c * y + s * z, c * z - s * y, c * w - s * x)
    force = tuple(G * axis for axis in up_in_body(q))
    assert rest(GravityDirection(), tilted, force) == ""


@pytest.mark.parametrize("mistake", MISTAKES)
@given(q=unit_quaternions, noise=st.floats(0.0, 0.05), seed=st.integers(0, 1000))
def test_a_mistake_is_found_and_named_wherever_it_shows(
    mistake: str, q: Vector, noise: float, seed: int
) -> None:
    apply, order, hint = MISTAKES[mistake]
    force = tuple(G * axis for axis in up_in_body(q))
    wrong_q, wrong_f = apply(q, force)
    assume(angle_to_up(wrong_q, wrong_f) > 24.0)
    check = GravityDirection(order)
    found = rest(check, wrong_q, wrong_f, noise=noise, seed=seed)
    assert found.startswith("at rest gravity is ")
    assert "\n" not in found
    # Other mistakes may explain the same pose; other poses tell them apart.
    draw = Random(seed)
    for number in range(1, 12):
        other = tuple(draw.gauss(0.0, 1.0) for _ in range(4))
        other = tuple(axis / math.hypot(*other) for axis in other)
        rest(
            check,
            *apply(other, tuple(G * axis for axis in up_in_body(other))),
            windows=1,
            since_s=10.0 * number,
        )
        if not check.finding:
            # A pose in which the mistake does not show.
            return
    assert hint in check.finding


@pytest.mark.parametrize(
    ("q", "f", "hints"),
    [
        # Level boards, as most rest: an identity sent as w, x, y, z.
        ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, G), ["order wxyz, not xyzw?"]),
        # A level sensor with z down, and one that reports gravity and not the force.
        (LEVEL, (0.0, 0.0, -G), ["does z point down (NED)"]),
        # In g: the unit is another check's, the direction is this one's.
        (LEVEL, (0.0, 0.0, -1.0), ["does z point down (NED)"]),
        # Tilted by 40 degrees about x, acceleration in FRD and orientation in FLU.
        ((0.342, 0.0, 0.0, 0.94), (0.0, -6.3, -7.5), ["does z point down", "FLU"]),
    ],
)
def test_the_usual_poses_tell_the_usual_mistakes(q: Vector, f: Vector, hints: list[str]) -> None:
    unit = tuple(axis / math.hypot(*q) for axis in q)
    found = rest(GravityDirection(), unit, f)
    assert found
    for hint in hints:
        assert hint in found, found


def test_angles_in_degrees_that_are_taken_for_radians_are_found_and_named() -> None:
    check = GravityDirection()
    for number, roll in enumerate((25.0, 40.0, -60.0)):
        # The firmware takes the sine and the cosine of that many radians, halved.
        force = (0.0, G * math.sin(math.radians(roll)), G * math.cos(math.radians(roll)))
        q = (math.sin(roll / 2), 0.0, 0.0, math.cos(roll / 2))
        rest(check, q, force, noise=0.03, since_s=10.0 * number)
    assert "is it made of angles in degrees where radians are due?" in check.finding


def test_a_mistake_that_is_not_usual_is_found_without_a_guess() -> None:
    check = GravityDirection()
    for number, up in enumerate([(0.0, 0.0, G), (0.0, G, 0.0), (G, 0.0, 0.0), (0.0, 0.0, -G)]):
        # Half a turn about an axis that is none of the sensor's.
        rest(check, (0.6, 0.48, 0.64, 0.0), up, since_s=10.0 * number)
    assert check.finding.endswith("is the mapping of its axes right?")


def test_a_moment_is_not_judged_nor_samples_without_an_orientation() -> None:
    wrong = (1.0, 0.0, 0.0, 0.0)
    assert rest(GravityDirection(), wrong, (0.0, 0.0, G), windows=2) == ""
    check = GravityDirection()
    for number in range(50):
        # A second altogether, at 2.5 kHz.
        check.judge(
            window_of([(0.0, 0.0, G)] * WINDOW, wrong, number * S // 50, (number + 1) * S // 50)
        )
    assert check.finding == ""
    for number in range(10):
        check.judge(window_of([(0.0, 0.0, -G)] * WINDOW, None, number * S, (number + 1) * S))
    assert check.finding == ""


def drive(check: GravityDirection, force: Callable[[float], Vector], seconds: float) -> str:
    """The first that is found in a level robot at 100 Hz that drives straight on."""
    began_ns = 0
    for start in range(0, round(seconds * 100), WINDOW):
        numbers = range(start, start + WINDOW)
        samples = [sample_of(force(number / 100), LEVEL) for number in numbers]
        ended_ns = round((start + WINDOW) / 100 * S)
        check.judge(summarise(samples, began_ns, ended_ns))
        if check.finding:
            break
        began_ns = ended_ns
    return check.finding


@pytest.mark.parametrize(
    ("force", "what"),
    [
        (lambda t: (3.4, 0.0, G), "braking gently for long"),
        (lambda t: (-6.0 if t % 5 < 1.2 else 0.0, 0.0, G), "braking hard, again and again"),
        (
            lambda t: (-3.9, 0.0, 9.5) if t % 7 < 0.6 else (0.0, 0.0, G + 3.0 * math.sin(60.0 * t)),
            "braking now and then, and never at rest in between",
        ),
        (lambda t: (5.0, 0.0, G), "a bend without a gyroscope: the force is too large"),
        (lambda t: (0.0, 0.0, 0.3), "falling"),
        (lambda t: (2.0 * math.sin(9 * t), 3.0 * math.cos(7 * t), G), "walking"),
    ],
)
def test_a_robot_that_drives_is_not_found_fault_with(
    force: Callable[[float], Vector], what: str
) -> None:
    assert drive(GravityDirection(), force, 60.0) == "", what


def test_a_hand_that_turns_a_board_is_not_found_fault_with() -> None:
    check, draw = GravityDirection(), Random(1)
    began_ns = 0
    for start in range(0, 6000, WINDOW):
        samples = []
        for number in range(start, start + WINDOW):
            motion = motion_at(number / 100)
            q, a = motion.orientation, motion.linear_acceleration
            force = (a.x + draw.gauss(0, 0.02), a.y + draw.gauss(0, 0.02), a.z)
            samples.append(sample_of(force, (q.x, q.y, q.z, q.w)))
        ended_ns = (start + WINDOW) * S // 100
        check.judge(summarise(samples, began_ns, ended_ns))
        assert check.finding == ""
        began_ns = ended_ns


def test_the_finding_goes_at_rest_when_the_cause_goes() -> None:
    check = GravityDirection()
    assert rest(check, LEVEL, (0.0, 0.0, -G))
    assert rest(check, LEVEL, (0.0, 0.0, G), windows=1, since_s=10.0) == ""


def swaying(sign: float) -> Sequence[tuple[Vector, Vector]]:
    """A window of a sensor on the move, in which the force is never at rest."""
    window = []
    for number in range(WINDOW):
        motion = motion_at(number / 10)
        q, a = motion.orientation, motion.linear_acceleration
        force = (a.x + 1.5 * (-1) ** (number // 2), a.y, a.z + 2.0 * (-1) ** (number // 3))
        window.append(((q.x, q.y, q.z, q.w), tuple(sign * axis for axis in force)))
    return window


def move(check: GravityDirection, sign: float, windows: int) -> str:
    for number in range(windows):
        samples = [sample_of(f, q) for q, f in swaying(sign)]
        began_ns = (20 + number) * S
        window = summarise(samples, began_ns, began_ns + S)
        assert not window.is_still
        check.judge(window)
    return check.finding


def test_the_finding_goes_in_motion_too_when_the_cause_goes_and_stays_if_it_does_not() -> None:
    check = GravityDirection()
    assert rest(check, LEVEL, (0.0, 0.0, -G))
    assert move(check, -1.0, 30)
    assert move(check, 1.0, 1), "a moment is no proof"
    assert move(check, 1.0, 10) == ""
