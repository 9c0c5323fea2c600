"""Whether somebody has set the date, or only had the processor for a while."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.stamps import ClockOffset

MS = 1_000_000
S = 1_000 * MS
DATE_NS = 1_700_000_000 * S

held_ns = st.sampled_from([0, 300, 40_000, 5 * MS, 80 * MS])


@given(st.lists(st.tuples(st.integers(0, 10 * S), held_ns, held_ns), max_size=50))
def test_a_busy_machine_sets_no_clock(looks: list[tuple[int, int, int]]) -> None:
    offset, at_ns = ClockOffset(), 0
    for pause_ns, before_ns, after_ns in looks:
        at_ns += pause_ns + before_ns + after_ns
        date_ns = at_ns - after_ns + DATE_NS
        assert offset.step(at_ns - before_ns - after_ns, date_ns, at_ns) == 0


@given(
    st.integers(3 * MS, 3_600 * S).flatmap(lambda n: st.sampled_from([n, -n])),
    st.integers(0, S),
    st.sampled_from([0, 300, 40_000, 900_000]),
)
def test_a_step_is_seen_once(step_ns: int, pause_ns: int, held: int) -> None:
    offset = ClockOffset()
    offset.step(0, DATE_NS, 0)
    at_ns = pause_ns + held
    seen_ns = offset.step(pause_ns, pause_ns + DATE_NS + step_ns, at_ns)
    assert abs(seen_ns - step_ns) <= held
    later_ns = at_ns + MS
    assert offset.step(later_ns, later_ns + DATE_NS + step_ns, later_ns) == 0


@pytest.mark.parametrize("ppm", [500, -500])
@pytest.mark.parametrize("pause_ns", [MS, S, 3_600 * S])
def test_slewing_is_no_step(ppm: int, pause_ns: int) -> None:
    offset = ClockOffset()
    for number in range(100):
        at_ns = number * pause_ns
        assert offset.step(at_ns, at_ns + DATE_NS + at_ns * ppm // 1_000_000, at_ns) == 0


def test_a_leap_second_that_is_repeated_is_a_step() -> None:
    offset = ClockOffset()
    offset.step(0, DATE_NS, 0)
    assert offset.step(10 * MS, DATE_NS + 10 * MS - S, 10 * MS) == -S


def test_time_that_the_machine_has_slept_is_no_step_if_it_is_known() -> None:
    offset = ClockOffset()
    offset.shift(S)
    offset.step(0, DATE_NS, 0)
    offset.shift(3_600 * S)
    assert offset.step(MS, DATE_NS + MS + 3_600 * S, MS) == 0
