"""Stamps of several samples in a message."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from rosbase.mapping.spreading import Spreading

MS = 1_000_000


def test_samples_are_spread_over_the_time_since_the_message_before() -> None:
    spreading = Spreading()
    spreading.stamps(4, 100 * MS)
    assert spreading.stamps(4, 120 * MS) == [105 * MS, 110 * MS, 115 * MS, 120 * MS]
    assert spreading.stamps(2, 130 * MS) == [125 * MS, 130 * MS]


def test_a_pause_before_a_message_says_nothing_of_its_samples() -> None:
    spreading = Spreading()
    for message in range(1, 6):
        spreading.stamps(4, message * 20 * MS)
    assert spreading.stamps(4, 10_000 * MS) == [9_985 * MS, 9_990 * MS, 9_995 * MS, 10_000 * MS]
    assert spreading.stamps(4, 10_020 * MS)[0] == 10_005 * MS


def test_the_interval_of_the_payload_counts_where_it_fits() -> None:
    spreading = Spreading()
    assert spreading.stamps(3, 100 * MS, 5 * MS) == [90 * MS, 95 * MS, 100 * MS]
    assert spreading.stamps(3, 115 * MS, 5 * MS) == [105 * MS, 110 * MS, 115 * MS]
    # None is older than the last one of the message before.
    assert spreading.stamps(3, 121 * MS, 5 * MS) == [117 * MS, 119 * MS, 121 * MS]


def test_a_clock_that_was_set_back_is_followed() -> None:
    spreading = Spreading()
    for message in range(1, 6):
        spreading.stamps(4, message * 20 * MS)
    assert spreading.stamps(4, 40 * MS) == [25 * MS, 30 * MS, 35 * MS, 40 * MS]


messages = st.lists(
    st.tuples(st.integers(1, 50), st.integers(100, 10**12), st.none() | st.integers(1, 10**10))
)


@given(messages)
def test_stamps_strictly_rise_and_end_at_the_message(
    arrivals: list[tuple[int, int, int | None]],
) -> None:
    spreading, now, last = Spreading(), 10**18, 0
    for count, gap, interval in arrivals:
        now += gap
        stamps = spreading.stamps(count, now, interval)
        assert len(stamps) == count
        assert stamps[-1] == now
        for stamp in stamps:
            assert stamp > last
            last = stamp


@given(st.integers(2, 20), st.integers(1, 20), st.integers(10**5, 10**8), st.integers(1, 10**12))
def test_samples_are_never_farther_apart_than_usually(
    messages: int, count: int, step: int, pause: int
) -> None:
    spreading, now = Spreading(), 10**18
    for _ in range(messages):
        now += count * step
        spreading.stamps(count, now)
    now += pause
    stamps = spreading.stamps(count, now)
    assert all(0 < b - a <= step for a, b in pairwise(stamps))
