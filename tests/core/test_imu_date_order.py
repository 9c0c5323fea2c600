"""Dates of the device: nothing is published twice or backwards, and a mended clock is followed."""

from hypothesis import given
from hypothesis import strategies as st

from rosbase.imu.date_order import DateOrder
from rosbase.imu.mapping import Sample

S = 1_000_000_000


def sample(date_ns: int, x: float = 0.0) -> Sample:
    return Sample(None, (x, 0.0, 0.0), (0.0, 0.0, 9.8), None, date_ns)


def judge(order: DateOrder, date_ns: int, arrived_ns: int, x: float = 0.0) -> str:
    reject = order.judge(sample(date_ns, x), date_ns, arrived_ns)
    return reject.reason if reject else ""


def test_what_is_delivered_again_or_late_is_dropped() -> None:
    order = DateOrder()
    seen = [judge(order, date, 9) for date in (10, 11, 11, 13, 12, 11, 14)]
    assert seen == ["", "", "duplicate", "", "out_of_order", "out_of_order", ""]


def test_two_samples_of_one_coarse_date_both_count() -> None:
    order = DateOrder()
    assert [judge(order, 5, n, x=n) for n in (1, 2, 3)] == ["", "", ""]


def test_a_clock_that_was_set_back_is_followed_after_two_seconds() -> None:
    order = DateOrder()
    assert judge(order, 3600 * S, 1 * S) == ""
    seen = [judge(order, 5 * S + n, (2 + n) * S) for n in range(4)]
    assert seen == ["out_of_order", "out_of_order", "", ""]


def test_a_clock_here_that_is_set_back_meanwhile_does_not_make_the_two_seconds_an_hour() -> None:
    order = DateOrder()
    assert judge(order, 9000 * S, 9000 * S) == ""
    assert judge(order, 5400 * S, 9001 * S) == "out_of_order"
    seen = [judge(order, (5401 + n) * S, (5401 + n) * S) for n in range(4)]
    assert seen == ["out_of_order", "out_of_order", "", ""]


def test_one_late_sample_now_and_then_never_counts_as_a_clock_that_was_set_back() -> None:
    order = DateOrder()
    for n in range(1, 20):
        assert judge(order, 100 * n, n * S) == ""
        assert judge(order, 100 * n - 50, n * S) == "out_of_order"


@given(st.lists(st.integers(1, 50)))
def test_within_two_seconds_what_goes_through_only_rises(dates: list[int]) -> None:
    order = DateOrder()
    through = [date for date in dates if not judge(order, date, 1)]
    assert through == sorted(set(through))
    assert set(through) == {
        date for n, date in enumerate(dates) if date > max(dates[:n], default=0)
    }
