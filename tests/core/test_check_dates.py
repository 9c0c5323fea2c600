"""Dates of the device: none twice, backwards or absurd, and a mended clock is followed."""

from datetime import datetime, timezone

import pytest
from hypothesis import given

from rosbase.imu.checks.device_clock import DeviceClock
from rosbase.imu.checks.device_dates import DeviceDates
from rosbase.imu.mapping import Sample
from rosbase.mapping.rejects import Reject
from support.strategies import DateEvent, date_streams

S = 1_000_000_000
MS = 1_000_000
NOW = 1_780_000_000 * S
HOUR = 3600 * S


def at(text: str) -> int:
    return round(datetime.fromisoformat(text).replace(tzinfo=timezone.utc).timestamp()) * S


def sample(date_ns: int | None, x: float = 0.0) -> Sample:
    return Sample(None, (x, 0.0, 0.0), (0.0, 0.0, 9.8), None, date_ns)


def judge(dates: DeviceDates, date_ns: int | None, arrived_ns: int, x: float = 0.0) -> str:
    """`date` if the sample goes out under its date, `arrival`, or the reason why it does not."""
    verdict = dates.judge(sample(date_ns, x), arrived_ns)
    if isinstance(verdict, Reject):
        return "arrival" if verdict.reason == "time_unusable" else verdict.reason
    if verdict is None:
        return "arrival"
    # Between two dates of a coarse clock the arrival tells.
    assert date_ns is not None
    assert 0 <= verdict - date_ns <= S
    return "date"


def run(dates: DeviceDates, *, since_ns: int, ahead_ns: int, number: int = 10) -> list[str]:
    """What becomes of samples at 10 Hz whose clock is ahead by so much."""
    times = [since_ns + n * 100 * MS for n in range(number)]
    return [judge(dates, time_ns + ahead_ns, time_ns) for time_ns in times]


def test_what_is_delivered_again_or_late_is_dropped() -> None:
    dates = DeviceDates()
    seen = [judge(dates, NOW + date, NOW) for date in (10, 11, 11, 13, 12, 11, 14)]
    assert seen == ["date", "date", "duplicate", "date", "out_of_order", "out_of_order", "date"]


def test_two_samples_of_one_coarse_date_both_count() -> None:
    dates = DeviceDates()
    assert [judge(dates, NOW, NOW + n, x=n) for n in (1, 2, 3)] == ["date"] * 3


@pytest.mark.parametrize(
    "absurd",
    ["2106-02-07", "2037-01-01", "1980-01-06", "2000-01-01", "2001-09-09", "2038-01-19 03:14:07"],
)
def test_one_absurd_date_is_dropped_and_costs_no_good_one(absurd: str) -> None:
    dates = DeviceDates()
    for number in range(5):
        assert run(dates, since_ns=NOW + number * 2 * S, ahead_ns=-3 * MS) == ["date"] * 10
        assert judge(dates, at(absurd), NOW + number * 2 * S + S) == "implausible_date"


@pytest.mark.parametrize("ahead_ns", [-12 * HOUR, -3 * S, 0, 90 * S, 5 * HOUR + 30 * 60 * S])
def test_an_absurd_date_is_dropped_whatever_the_devices_clock_says(ahead_ns: int) -> None:
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=ahead_ns)
    assert judge(dates, NOW + 40 * 86_400 * S, NOW + S) == "implausible_date"
    assert judge(dates, NOW - 40 * 86_400 * S, NOW + S) == "implausible_date"
    assert run(dates, since_ns=NOW + 2 * S, ahead_ns=ahead_ns) == ["date"] * 10


def test_an_absurd_date_at_the_start_does_not_begin_a_run() -> None:
    dates = DeviceDates()
    assert judge(dates, at("2036-02-07"), NOW) == "implausible_date"
    assert run(dates, since_ns=NOW, ahead_ns=0) == ["date"] * 10


def test_a_wrong_date_of_the_same_day_at_the_start_costs_nothing_either() -> None:
    dates = DeviceDates()
    assert judge(dates, NOW + 3 * HOUR, NOW) == "date"
    assert run(dates, since_ns=NOW + S, ahead_ns=0) == ["date"] * 10


def test_a_clock_that_was_never_set_counts_once_three_dates_agree() -> None:
    dates = DeviceDates()
    ahead_ns = at("2000-01-01") - NOW
    seen = run(dates, since_ns=NOW, ahead_ns=ahead_ns, number=6)
    assert seen == ["implausible_date"] * 2 + ["date"] * 4


def test_a_clock_that_is_put_forward_is_followed_after_two_samples_or_at_once_if_right() -> None:
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=0)
    seen = run(dates, since_ns=NOW + 2 * S, ahead_ns=2 * HOUR, number=4)
    assert seen == ["implausible_date"] * 2 + ["date"] * 2
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=-2 * HOUR)
    assert run(dates, since_ns=NOW + 2 * S, ahead_ns=0) == ["date"] * 10


def test_a_clock_that_was_set_back_is_followed_after_two_seconds() -> None:
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=0)
    seen = run(dates, since_ns=NOW + S, ahead_ns=-600 * S, number=22)
    assert seen == ["out_of_order"] * 20 + ["date"] * 2


def test_a_clock_that_was_ahead_and_is_mended_is_followed_at_once() -> None:
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=5 * HOUR)
    assert run(dates, since_ns=NOW + 2 * S, ahead_ns=0) == ["date"] * 10


def test_a_clock_here_that_is_set_back_meanwhile_does_not_make_the_two_seconds_an_hour() -> None:
    dates = DeviceDates()
    assert judge(dates, 9000 * S + NOW, 9000 * S + NOW) == "date"
    assert judge(dates, 5400 * S + NOW, 9001 * S + NOW) == "out_of_order"
    seen = [judge(dates, (5401 + n) * S + NOW, (8000 + n) * S + NOW) for n in range(4)]
    assert seen == ["out_of_order", "out_of_order", "date", "date"]


def test_a_clock_here_that_is_set_costs_nothing_while_the_dates_go_on() -> None:
    for step_ns in (-HOUR, HOUR):
        dates = DeviceDates()
        assert run(dates, since_ns=NOW, ahead_ns=0) == ["date"] * 10
        seen = run(dates, since_ns=NOW + S + step_ns, ahead_ns=-step_ns)
        assert seen == ["date"] * 10


def test_one_late_sample_now_and_then_never_counts_as_a_clock_that_was_set_back() -> None:
    dates = DeviceDates()
    for n in range(1, 20):
        assert judge(dates, NOW + n * S, NOW + n * S) == "date"
        assert judge(dates, NOW + n * S - 50, NOW + n * S) == "out_of_order"


def test_what_a_network_held_up_goes_out_under_its_dates_and_so_does_what_comes_after() -> None:
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=4 * HOUR)
    held_up = [judge(dates, NOW + 4 * HOUR + (10 + n) * 100 * MS, NOW + 11 * S) for n in range(100)]
    assert held_up == ["date"] * 100
    assert run(dates, since_ns=NOW + 11 * S, ahead_ns=4 * HOUR + 1) == ["date"] * 10


def test_what_has_no_date_is_stamped_on_arrival() -> None:
    dates = DeviceDates()
    assert {judge(dates, None, NOW + n * 100 * MS) for n in range(30)} == {"arrival"}


def test_a_sample_without_a_date_among_dates_is_stamped_on_arrival_if_that_fits_in() -> None:
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=-5 * MS)
    assert judge(dates, None, NOW + S) == "arrival"
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=5 * HOUR)
    assert judge(dates, None, NOW + S) == "implausible_date"
    # A device that has lost its clock for good.
    assert judge(dates, None, NOW + 4 * S) == "arrival"


def test_where_all_dates_are_absurd_the_arrival_counts_and_why_is_said() -> None:
    dates = DeviceDates()
    for n in range(30):
        verdict = dates.judge(sample(at("2106-02-07")), NOW + n * 100 * MS)
        assert isinstance(verdict, Reject)
        assert verdict.reason == "time_unusable"
        assert verdict.detail.startswith("dated 2106-02-07 00:00:00 UTC; ")


def test_a_machine_that_does_not_know_the_date_doubts_no_first_one() -> None:
    for unset_ns in (7, 60 * S, 20 * 365 * 86_400 * S):
        dates = DeviceDates()
        assert judge(dates, NOW, unset_ns) == "date"


def test_a_clock_that_is_stuck_far_away_gives_way_to_the_arrival() -> None:
    dates = DeviceDates()
    seen = [judge(dates, at("2036-05-05"), NOW + n * 100 * MS, x=n) for n in range(60)]
    assert seen == ["implausible_date"] * 20 + ["arrival"] * 40


def test_a_coarse_clock_that_is_far_away_counts_once_it_has_ticked_twice() -> None:
    dates = DeviceDates()
    ahead_ns = -3 * 365 * 86_400 * S
    times = [NOW + n * 100 * MS for n in range(60)]
    seen = [judge(dates, (t + ahead_ns) // S * S, t, x=t) for t in times]
    assert "date" in seen[:30]
    assert seen[30:] == ["date"] * 30


def test_dates_that_leap_about_are_never_taken() -> None:
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=0)
    seen = {judge(dates, NOW + 86_400 * S * (7 * n % 97), NOW + S + n * MS) for n in range(1, 90)}
    assert seen == {"implausible_date"}


def test_a_replay_gives_way_to_dates_that_are_a_few_seconds_old() -> None:
    dates = DeviceDates()
    run(dates, since_ns=NOW, ahead_ns=-3 * 365 * 86_400 * S)
    assert judge(dates, NOW - 10 * S, NOW + 2 * S) == "date"


STRICT = 5.0


def test_a_strict_reader_publishes_no_date_of_a_wrong_clock() -> None:
    dates = DeviceDates(DeviceClock(STRICT), is_strict=True)
    seen = run(dates, since_ns=NOW, ahead_ns=5 * HOUR + HOUR // 2, number=60)
    assert "date" not in seen
    assert seen[-30:] == ["arrival"] * 30
    assert seen[0] == "implausible_date"
    assert "5 h 30 min ahead: a time zone?" in dates.finding
    # It heals.
    seen = run(dates, since_ns=NOW + 7 * S, ahead_ns=0, number=30)
    assert seen == ["date"] * 30
    assert dates.finding == ""


def test_a_strict_reader_does_not_publish_as_new_what_was_held_up() -> None:
    dates = DeviceDates(DeviceClock(STRICT), is_strict=True)
    run(dates, since_ns=NOW, ahead_ns=0)
    old = [judge(dates, NOW + S + n * MS, NOW + 20 * S) for n in range(50)]
    assert set(old) == {"implausible_date"}


@given(date_streams())
def test_outliers_steps_and_duplicates_never_make_a_wrong_date_go_out(
    stream: list[DateEvent],
) -> None:
    dates = DeviceDates(DeviceClock(5.0))
    through: list[DateEvent] = []
    for event in stream:
        verdict = dates.judge(sample(event.date_ns, event.x), event.arrived_ns)
        if isinstance(verdict, int):
            assert verdict == event.date_ns
            through.append(event)
    assert [event for event in through if event.kind == "outlier"] == []
    numbers = [event.x for event in through]
    assert len(set(numbers)) == len(numbers), "nothing goes out twice"
    by_run: dict[int, list[int]] = {}
    for event in through:
        by_run.setdefault(event.run, []).append(event.date_ns)
    for dates_ns in by_run.values():
        assert dates_ns == sorted(dates_ns)
    # What a step may cost: two samples when put forward, two seconds from the first one on when
    # set back; all other good ones go out.
    sent = [event for event in stream if event.kind == "good"]
    lost = [event for event in sent if event.x not in numbers]
    assert all(event.since_step < 2 or event.since_step_ns <= 3 * S for event in lost)
