from random import Random

import pytest

from rosbase.imu.plausibility import Plausibility


def finding(z: float, *, noise: float = 0.0, samples: int = 50, seed: int = 1) -> str:
    """What is found in samples at rest: `z` upwards, and noise on every axis."""
    check, draw = Plausibility(), Random(seed)
    for _ in range(samples):
        check.add((draw.gauss(0, noise), draw.gauss(0, noise), z + draw.gauss(0, noise)))
    return check.finding


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


def test_a_few_samples_are_not_judged() -> None:
    assert finding(1.0, samples=49) == ""


def test_the_finding_goes_when_the_cause_goes() -> None:
    check = Plausibility()
    for z in (1.0, 9.81):
        for _ in range(50):
            check.add((0.0, 0.0, z))
    assert check.finding == ""


def test_a_finding_survives_motion() -> None:
    check = Plausibility()
    for _ in range(50):
        check.add((0.0, 0.0, 1.0))
    for number in range(50):
        check.add((0.0, 0.0, float(number)))
    assert "in g?" in check.finding
