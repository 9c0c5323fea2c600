"""Frozen runs: a sensor that repeats itself is found, one that is merely at rest is not."""

from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.imu.checks.frozen import Frozen
from rosbase.imu.mapping import Sample
from rosbase.imu.units import STANDARD_GRAVITY

S = 1_000_000_000
SI = {"linear_acceleration": 1.0, "angular_velocity": 1.0, "magnetic_field": 1.0}
IN_G = {**SI, "linear_acceleration": STANDARD_GRAVITY, "angular_velocity": 0.0174533}

FINE = Sample(None, (0.0012, -0.0034, 0.0005), (0.0123, -0.0456, 9.7981), None, None)


class Stream:
    """Sends samples at a fixed rate to a check."""

    def __init__(self, check: Frozen, rate_hz: float = 100.0) -> None:
        self.check, self._period_ns, self._now_ns = check, round(S / rate_hz), S
        self.first_found_s: float | None = None

    def send(self, *samples: Sample, seconds: float = 0.0) -> str:
        """Sends the samples once, or over and over for so many seconds."""
        end_ns = self._now_ns + round(seconds * S)
        while True:
            for sample in samples:
                self.check.add(sample, self._now_ns)
                if self.check.finding and self.first_found_s is None:
                    self.first_found_s = self._now_ns / S - 1.0
                self._now_ns += self._period_ns
            if self._now_ns >= end_ns:
                return self.check.finding


def stream(after_s: float = 2.0, rate_hz: float = 100.0, units: dict[str, float] = SI) -> Stream:
    return Stream(Frozen(after_s, units), rate_hz)


def test_two_seconds_of_the_same_sample_are_found_and_the_next_one_heals_it() -> None:
    sender = stream()
    assert sender.send(FINE, seconds=1.9) == ""
    assert "all numbers are the same, to the last digit" in sender.send(FINE, seconds=0.3)
    assert sender.first_found_s == pytest.approx(2.0, abs=0.03)
    other = FINE._replace(angular_velocity=(0.0012, -0.0034, 0.0006))
    assert sender.send(other) == ""


@pytest.mark.parametrize(("rate_hz", "found_s"), [(1.0, 20.0), (5.0, 4.0), (1000.0, 2.0)])
def test_slow_sensors_get_twenty_samples_and_fast_ones_two_seconds(
    rate_hz: float, found_s: float
) -> None:
    sender = stream(rate_hz=rate_hz)
    assert sender.send(FINE, seconds=30.0)
    assert sender.first_found_s == pytest.approx(found_s, abs=2.1 / rate_hz)


def test_the_seconds_are_a_parameter() -> None:
    sender = stream(after_s=10.0)
    assert sender.send(FINE, seconds=9.9) == ""
    assert sender.send(FINE, seconds=0.3)


def test_the_text_stays_while_it_lasts() -> None:
    sender = stream()
    assert sender.send(FINE, seconds=3.0) == sender.send(FINE, seconds=60.0)


@pytest.mark.parametrize("quantity", ["orientation", "angular_velocity", "magnetic_field"])
def test_one_quantity_that_moves_is_enough(quantity: str) -> None:
    sender = stream()
    for number in range(500):
        other = (0.1 + number * 1e-6, 0.2, 0.3, 0.9)[: 4 if quantity == "orientation" else 3]
        changed: dict[str, Any] = {quantity: other}
        assert sender.send(FINE._replace(**changed)) == ""


def test_a_slower_magnetometer_and_quantities_in_lines_of_their_own_are_no_freeze() -> None:
    sender, draw = stream(), Random(1)
    field = (20e-6, 1e-6, -43e-6)
    for number in range(600):
        rate = (draw.gauss(0, 0.001), 0.0, 0.0)
        force = (draw.gauss(0, 0.02), 0.0, 9.8)
        lines = [
            Sample(None, rate, None, None, None),
            Sample(None, None, force, None, None),
            Sample(None, None, None, field, None),
        ]
        assert sender.send(lines[number % 3]) == ""


def test_frozen_quantities_in_lines_of_their_own_are_found() -> None:
    sender = stream()
    lines = [FINE._replace(linear_acceleration=None), FINE._replace(angular_velocity=None)]
    assert sender.send(*lines, seconds=5.0)


def test_a_date_or_a_counter_beside_them_does_not_hide_it() -> None:
    sender = stream()
    for number in range(300):
        sender.send(FINE._replace(device_time_ns=number))
    assert sender.check.finding


@pytest.mark.parametrize(
    ("rate", "force", "units", "is_found"),
    [
        # With one or two digits, noise is rounded away: a sensor at rest repeats itself.
        ((0.0, 0.0, 0.0), (0.1, 0.0, 9.8), SI, False),
        ((0.0, 0.0, 0.18), (0.0, 0.0, 9.8), SI, False),
        ((0.01, 0.0, 0.02), (0.0, 0.0, 10.0), SI, False),
        # With more, it would show.
        ((0.01, 0.0, 0.02), (0.12, -0.05, 9.79), SI, True),
        ((0.001, 0.0, -0.002), (0.1, 0.0, 9.8), SI, True),
        # The digits of the payload count, not those that a unit makes of them.
        ((0.0, 0.0, 0.0), (0.02, -0.01, 0.98), IN_G, False),
        ((0.0, 0.0, 0.5), (0.0, 0.0, 1.0), IN_G, False),
        ((0.0, 0.0, 0.0), (0.021, -0.013, 0.984), IN_G, True),
        ((0.12, -0.34, 0.56), (0.02, -0.01, 0.98), IN_G, True),
    ],
)
def test_equal_numbers_mean_something_only_if_they_have_the_digits_for_noise(
    rate: tuple[float, ...], force: tuple[float, ...], units: dict[str, float], is_found: bool
) -> None:
    in_si = Sample(
        None,
        tuple(number * units["angular_velocity"] for number in rate),
        tuple(number * units["linear_acceleration"] for number in force),
        None,
        None,
    )
    assert bool(stream(units=units).send(in_si, seconds=20.0)) is is_found


def test_a_quiet_sensor_that_has_repeated_itself_for_some_time_is_given_more() -> None:
    sender = stream()
    other = FINE._replace(linear_acceleration=(0.0123, -0.0456, 9.7982))
    sender.send(FINE, seconds=1.5)
    assert sender.send(other, seconds=5.0) == "", "four times as long as what ended by itself"
    assert sender.send(other, seconds=1.5)


def test_who_has_hung_for_long_is_found_again() -> None:
    sender = stream()
    other = FINE._replace(linear_acceleration=(0.0123, -0.0456, 9.7982))
    sender.send(FINE, seconds=300.0)
    assert sender.send(other, seconds=11.0)


@given(st.integers(0, 1000), st.sampled_from([3, 4, 6]), st.sampled_from([10.0, 100.0, 400.0]))
def test_a_live_sensor_at_rest_is_never_found_fault_with(
    seed: int, digits: int, rate_hz: float
) -> None:
    sender, draw = stream(rate_hz=rate_hz), Random(seed)
    for _ in range(1000):
        rate = tuple(round(draw.gauss(0.0, 0.001), digits) for _ in range(3))
        force = tuple(round(axis + draw.gauss(0.0, 0.01), digits) for axis in (0.0, 0.0, 9.81))
        assert sender.send(Sample(None, rate, force, None, None)) == ""
