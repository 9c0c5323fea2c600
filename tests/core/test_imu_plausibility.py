import pytest

from rosbase.imu.plausibility import Plausibility

REST = (0.001, 0.0, -0.001)


def finding(z: float, *, wobble: float = 0.0, rate: float = 0.0, samples: int = 50) -> str:
    check = Plausibility()
    for number in range(samples):
        sign = 1 if number % 2 else -1
        check.add((0.0, 0.0, z + sign * wobble), (sign * rate, 0.0, 0.0))
    return check.finding


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
def test_gravity_at_rest_tells_a_wrong_unit(z: float, hint: str) -> None:
    found = finding(z)
    assert hint in found
    assert bool(found) is bool(hint)
    assert "\n" not in found


def test_a_moving_sensor_is_not_judged() -> None:
    assert finding(1.0, wobble=0.5) == ""
    assert finding(1.0, rate=1.0) == ""


def test_a_few_samples_are_not_judged() -> None:
    assert finding(1.0, samples=49) == ""


def test_the_finding_goes_when_the_cause_goes() -> None:
    check = Plausibility()
    for z in (1.0, 9.81):
        for _ in range(50):
            check.add((0.0, 0.0, z), None)
    assert check.finding == ""


def test_a_finding_survives_motion() -> None:
    check = Plausibility()
    for _ in range(50):
        check.add((0.0, 0.0, 1.0), REST)
    for number in range(50):
        check.add((0.0, 0.0, float(number)), REST)
    assert "in g?" in check.finding
