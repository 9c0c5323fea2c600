"""Stamps of device dates: they rise, however coarse the clock of the device is."""

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.imu.checks.date_pace import DatePace
from rosbase.imu.checks.device_dates import DeviceDates
from rosbase.imu.mapping import Sample

S, MS = 1_000_000_000, 1_000_000
NOW = 1_780_000_000 * S


@given(
    gaps=st.lists(st.integers(1, 300 * MS), min_size=2, max_size=300),
    step_ns=st.sampled_from([1, MS, 10 * MS, S, 128 * S]),
    delays=st.randoms(use_true_random=False),
)
def test_stamps_rise_and_stay_near_the_dates(gaps: list[int], step_ns: int, delays: Random) -> None:
    pace, sent_ns, arrived_ns, last_ns = DatePace(), NOW, NOW, 0
    for gap_ns in gaps:
        sent_ns += gap_ns
        arrived_ns = max(arrived_ns + 1, sent_ns + delays.randint(0, 20 * MS))
        date_ns = sent_ns // step_ns * step_ns
        stamp_ns = pace.stamp(date_ns, arrived_ns)
        assert stamp_ns > last_ns
        assert -1 <= stamp_ns - date_ns <= step_ns + 40 * MS + len(gaps)
        last_ns = stamp_ns


def test_dates_that_rise_are_the_stamps() -> None:
    pace = DatePace()
    for number in range(100):
        assert pace.stamp(NOW + number * 10 * MS, NOW + number * 10 * MS + number % 7) == (
            NOW + number * 10 * MS
        )
    assert pace.finding == ""


def test_a_clock_of_whole_seconds_is_said_and_heals() -> None:
    pace = DatePace()
    stamps = [pace.stamp((NOW + n * 20 * MS) // S * S, NOW + n * 20 * MS) for n in range(250)]
    assert stamps == [NOW + n * 20 * MS for n in range(250)]
    assert pace.finding.startswith("the device's dates repeat")
    for n in range(250, 300):
        pace.stamp(NOW + n * 20 * MS + MS, NOW + n * 20 * MS)
    assert pace.finding == ""


def test_a_clock_that_is_set_back_is_followed_at_once() -> None:
    pace = DatePace()
    assert pace.stamp(NOW, NOW) == NOW
    assert pace.stamp(NOW - 60 * S, NOW + MS) == NOW - 60 * S
    assert pace.stamp(NOW - 60 * S, NOW + 2 * MS) == NOW - 60 * S + MS


def test_stamps_that_ran_ahead_let_the_dates_catch_up() -> None:
    pace = DatePace()
    pace.stamp(NOW, NOW)
    assert pace.stamp(NOW, NOW + 500 * MS) == NOW + 500 * MS
    stamps = [pace.stamp(NOW + n * 10 * MS, NOW + (500 + n * 10) * MS) for n in range(1, 200)]
    assert stamps == sorted(set(stamps))
    assert stamps[-1] == NOW + 1990 * MS


@pytest.mark.parametrize("number", [2, 4, 50])
def test_samples_of_one_message_with_one_date_have_stamps_that_rise(number: int) -> None:
    dates, last_ns = DeviceDates(), 0
    for message in range(20):
        date_ns = NOW + message * 100 * MS
        for index in range(number):
            arrived_ns = date_ns + 5 * MS + index * 100 * MS // number
            sample = Sample(None, None, (0.0, 0.0, float(index)), None, date_ns)
            stamp_ns = dates.judge(sample, arrived_ns)
            assert isinstance(stamp_ns, int)
            assert stamp_ns > last_ns
            last_ns = stamp_ns
