"""Curves: what they keep, and when they start anew."""

from hypothesis import given
from hypothesis import strategies as st

from rosbase_view.web.trace import SPAN_S, Trace

SECOND = 1_000_000_000


def trace_of(*stamps_s: float) -> Trace:
    trace = Trace()
    for stamp_s in stamps_s:
        trace.add(int(stamp_s * SECOND), (stamp_s, -stamp_s))
    return trace


def test_a_curve_ends_at_the_newest_sample() -> None:
    assert trace_of(100.0, 100.5, 101.0).columns() == [
        [-1.0, -0.5, 0.0],
        (100.0, 100.5, 101.0),
        (-100.0, -100.5, -101.0),
    ]


def test_no_samples_are_no_columns() -> None:
    assert Trace().columns() == []


def test_only_the_last_seconds_are_kept() -> None:
    seconds = trace_of(*range(100)).columns()[0]
    assert seconds[0] == -SPAN_S
    assert len(seconds) == SPAN_S + 1


def test_a_time_that_goes_back_starts_anew() -> None:
    assert trace_of(100.0, 101.0, 50.0).columns()[1] == (50.0,)


def test_a_long_gap_starts_anew() -> None:
    assert trace_of(1.0, 2.0, 10.0, 11.0).columns()[1] == (10.0, 11.0)


def test_a_message_that_comes_twice_is_one_sample() -> None:
    trace = trace_of(1.0, 2.0)
    revision = trace.revision
    trace.add(2 * SECOND, (2.0, -2.0))
    assert trace.revision == revision


@given(st.lists(st.integers(0, 10**12), max_size=50))
def test_whatever_the_stamps_are_the_seconds_grow_within_the_span(stamps: list[int]) -> None:
    trace = Trace()
    for stamp in stamps:
        trace.add(stamp, (float(stamp),))
    columns = trace.columns()
    assert bool(columns) == bool(stamps)
    if columns:
        seconds, values = columns
        assert list(seconds) == sorted(set(seconds))
        assert len(values) == len(seconds)
        assert seconds[-1] == 0.0
        assert seconds[0] >= -SPAN_S


def test_a_fast_topic_does_not_fill_the_memory() -> None:
    trace = Trace()
    for number in range(5_000):
        trace.add(number, (0.0,))
    assert len(trace.columns()[0]) == 1_000
