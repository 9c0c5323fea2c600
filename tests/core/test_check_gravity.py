"""The norm of gravity: a wrong unit is found at rest, and a finding does not outlive its cause."""

from collections.abc import Sequence
from random import Random

import pytest

from rosbase.imu.checks.gravity import Gravity
from rosbase.imu.checks.window import WINDOW
from support.windows import window_of


def finding(z: float, *, noise: float = 0.0, seed: int = 1) -> str:
    """What is found in samples at rest: `z` upwards, and noise on every axis."""
    check, draw = Gravity(), Random(seed)
    check.judge(
        window_of(
            [
                (draw.gauss(0, noise), draw.gauss(0, noise), z + draw.gauss(0, noise))
                for _ in range(WINDOW)
            ]
        )
    )
    return check.finding


def judge(check: Gravity, *norms: float) -> None:
    check.judge(window_of([(0.0, 0.0, norm) for norm in norms] * (WINDOW // len(norms))))


def moving(around: float, swing: float) -> Sequence[float]:
    """Norms of a sensor that is moved, so that they vary by more than noise."""
    return (around - swing, around + swing)


@pytest.mark.parametrize("noise", [0.0, 0.02, 0.06])
@pytest.mark.parametrize(
    ("z", "hint"),
    [
        (9.81, ""),
        (9.2, ""),
        (-9.81, ""),
        (1.0, "in g?"),
        (1000.0, "in mg?"),
        (0.0, "taken gravity out"),
        (32.2, "unit right?"),
    ],
)
def test_gravity_at_rest_tells_a_wrong_unit_with_the_noise_of_real_sensors(
    z: float, hint: str, noise: float
) -> None:
    for seed in range(20):
        found = finding(z, noise=noise, seed=seed)
        assert hint in found
        assert bool(found) is bool(hint)
        assert "\n" not in found


def test_a_moving_sensor_is_not_judged() -> None:
    assert finding(5.0, noise=2.0) == ""


def test_the_finding_goes_when_the_cause_goes() -> None:
    check = Gravity()
    judge(check, 1.0)
    judge(check, 9.81)
    assert check.finding == ""


def test_a_finding_survives_motion_that_does_not_contradict_it() -> None:
    check = Gravity()
    judge(check, 1.0)
    for _ in range(10):
        judge(check, *moving(24.5, 20.0))
        judge(check, *moving(1.1, 0.4))
    assert "in g?" in check.finding


@pytest.mark.parametrize("while_booting", [0.0, 1.0, 1000.0, 16.0])
def test_a_finding_heals_while_a_sensor_moves_about_gravity(while_booting: float) -> None:
    check = Gravity()
    judge(check, while_booting)
    assert check.finding
    judge(check, *moving(9.9, 1.5))
    assert check.finding, "one window is no proof"
    judge(check, *moving(9.5, 2.0))
    assert check.finding == ""


def test_a_motion_that_is_as_near_to_the_finding_does_not_heal_it() -> None:
    check = Gravity()
    judge(check, 12.0)
    for _ in range(10):
        judge(check, *moving(12.1, 1.0))
    assert "unit right?" in check.finding


def test_a_sensor_without_gravity_does_not_pass_for_a_moving_one() -> None:
    check = Gravity()
    judge(check, 0.0)
    for _ in range(10):
        judge(check, *moving(2.5, 2.4))
    assert "taken gravity out" in check.finding


def test_the_text_of_a_finding_does_not_change_with_the_noise() -> None:
    check = Gravity()
    judge(check, 1.02)
    before = check.finding
    judge(check, 0.98)
    assert check.finding == before
    judge(check, 0.5)
    assert check.finding != before
