"""The device's clock: how far it is off is told in words that say what to look for."""

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.imu.checks.device_clock import DeviceClock

S = 1_000_000_000
MINUTE, HOUR, DAY, YEAR = 60 * S, 3600 * S, 86_400 * S, 31_557_600 * S
NOW = 1_780_000_000 * S


def watch(
    clock: DeviceClock,
    ahead_ns: int,
    *,
    seconds: float = 3.0,
    rate_hz: float = 20.0,
    since_s: float = 0.0,
    gains: float = 0.0,
    delays_s: float = 0.0,
) -> str:
    """What is found while samples come whose clock is ahead by so much, and gains."""
    draw = Random(1)
    for number in range(round(seconds * rate_hz)):
        t = since_s + number / rate_hz
        delay_s = draw.uniform(0.0, delays_s)
        ahead = ahead_ns + round((gains * (number / rate_hz) - delay_s) * S)
        clock.add(ahead, NOW + round(t * S))
    return clock.finding


@pytest.mark.parametrize(
    ("ahead_ns", "said"),
    [
        (5 * HOUR + 30 * MINUTE, "the device's clock is 5 h 30 min ahead: a time zone?"),
        (-8 * HOUR - S, "the device's clock is 8 h behind: a time zone?"),
        (2 * HOUR + 3 * S, "the device's clock is 2 h ahead: a time zone?"),
        (5 * HOUR + 45 * MINUTE, "the device's clock is 5 h 45 min ahead: a time zone?"),
        (-3 * HOUR - 30 * MINUTE, "the device's clock is 3 h 30 min behind: a time zone?"),
        (30 * MINUTE, "the device's clock is 30 min ahead: a time zone?"),
        (18 * S, "the device's clock is 18 s ahead: GPS time, without its leap seconds?"),
        (-1024 * 7 * DAY, "a GPS receiver that counts its weeks from another year?"),
        (47 * S, "the device's clock is 47 s ahead: are both clocks set?"),
        (-95 * S, "the device's clock is 1 min 35 s behind: are both clocks set?"),
        (2 * HOUR + 17 * MINUTE, "the device's clock is 2 h 17 min ahead: are both clocks set?"),
        (15 * HOUR, "the device's clock is 15 h ahead: are both clocks set?"),
        (3 * DAY + 4 * HOUR, "the device's clock is 3 days 4 h ahead: are both clocks set?"),
        (
            -26 * YEAR - 100 * DAY,
            "clock is 26 years 100 days behind: are both clocks set?",
        ),
        (6 * S, "the device's clock is 6.0 s ahead: are both clocks set?"),
    ],
)
def test_an_offset_is_said_with_its_likely_cause(ahead_ns: int, said: str) -> None:
    assert said in watch(DeviceClock(5.0), ahead_ns)


@pytest.mark.parametrize("ahead_ns", [0, -4 * S, 4 * S, -30_000_000])
def test_within_the_limit_nothing_is_said(ahead_ns: int) -> None:
    assert watch(DeviceClock(5.0), ahead_ns, seconds=600.0, delays_s=0.9) == ""


def test_the_limit_is_a_parameter() -> None:
    assert "0.5 s ahead" in watch(DeviceClock(0.1), S // 2)
    assert watch(DeviceClock(60.0), 47 * S) == ""


def test_a_delay_is_no_clock_that_is_behind() -> None:
    clock = DeviceClock(5.0)
    assert watch(clock, 0, delays_s=30.0, seconds=20.0) == "", "one of them is always quick"
    # A stall of eight seconds ends in a burst.
    for number in range(160):
        clock.add(-8 * S + number * S // 20, NOW + 30 * S + number)
    assert watch(clock, 0, since_s=30.1) == ""


def test_the_finding_goes_when_the_clock_is_set_and_comes_back() -> None:
    clock = DeviceClock(5.0)
    assert watch(clock, HOUR)
    assert watch(clock, 0, since_s=4.0) == ""
    assert watch(clock, -HOUR, since_s=8.0)


def test_a_host_whose_date_is_set_gets_another_finding() -> None:
    clock = DeviceClock(5.0)
    assert watch(clock, 0) == ""
    assert "1 h behind" in watch(clock, -HOUR, since_s=3600.0)
    assert watch(clock, 0, since_s=3.0) == ""


def test_the_text_stays_while_the_offset_is_about_the_same() -> None:
    clock = DeviceClock(5.0)
    assert watch(clock, 60 * S) == watch(clock, 61 * S, since_s=4.0)
    assert "2 min" in watch(clock, 125 * S, since_s=8.0)


@pytest.mark.parametrize(
    ("gains", "said"),
    [
        (0.01, "gains 0.6 s a minute"),
        (-0.02, "loses 1.2 s a minute"),
        (0.1, "gains 6.0 s a minute"),
    ],
)
def test_a_clock_that_drifts_is_said_before_it_is_far_off(gains: float, said: str) -> None:
    clock = DeviceClock(5.0)
    assert watch(clock, 0, seconds=75.0, gains=gains, delays_s=0.05).count(said) == 1
    assert watch(clock, 0, seconds=75.0, since_s=75.0, delays_s=0.05) == "", "and it heals"


def test_a_clock_that_is_far_off_and_drifts_is_said_to_do_both() -> None:
    found = watch(DeviceClock(5.0), 100 * S, seconds=120.0, gains=0.02)
    assert "is 1 min" in found
    assert "gains 1.2 s a minute" in found


@given(st.floats(-0.002, 0.002), st.integers(-4, 4), st.floats(0.0, 0.3))
def test_a_clock_that_is_set_gently_or_a_plain_crystal_is_no_drift(
    gains: float, ahead_s: int, delays_s: float
) -> None:
    clock = DeviceClock(5.0)
    assert watch(clock, ahead_s * S, seconds=120.0, gains=gains, delays_s=delays_s) == ""


@pytest.mark.parametrize("rate_hz", [0.5, 1.0, 1000.0])
def test_at_any_rate_it_is_said_within_seconds(rate_hz: float) -> None:
    assert watch(DeviceClock(5.0), HOUR, rate_hz=rate_hz, seconds=max(2.2, 6.0 / rate_hz))
