"""Several stamps at even distances."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.stamps import spread

moments = st.integers(-(10**18), 10**19)


@given(st.integers(1, 200), moments, st.integers(1, 10**10), st.none() | st.integers(1, 10**10))
def test_stamps_rise_evenly_between_the_two_moments(
    count: int, after_ns: int, room_ns: int, widest_ns: int | None
) -> None:
    until_ns = after_ns + room_ns
    stamps = list(spread(count, after_ns, until_ns, widest_ns))
    assert len(stamps) == count
    assert stamps[0] > after_ns
    gaps = {after - before for before, after in pairwise(stamps)}
    assert len(gaps) <= 1
    assert all(gap > 0 for gap in gaps)
    if room_ns >= count:
        assert stamps[-1] == until_ns
        for gap in gaps:
            assert gap == min(room_ns // count, widest_ns or room_ns)


@pytest.mark.parametrize(
    ("count", "after", "until", "widest", "stamps"),
    [
        (1, 0, 100, None, [100]),
        (4, 0, 100, None, [25, 50, 75, 100]),
        (4, 0, 100, 10, [70, 80, 90, 100]),
        (3, 0, 100, None, [34, 67, 100]),
        # No room: they must rise all the same.
        (3, 100, 100, None, [101, 102, 103]),
        (3, 100, 50, None, [101, 102, 103]),
        (3, 98, 100, None, [99, 100, 101]),
    ],
)
def test_how_stamps_are_spread(
    count: int, after: int, until: int, widest: int | None, stamps: list[int]
) -> None:
    assert list(spread(count, after, until, widest)) == stamps
