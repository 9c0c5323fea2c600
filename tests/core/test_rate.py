import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.runtime.rate import LoopStats, Rate

busy_ns = st.lists(st.integers(0, 60_000_000), max_size=50)


@given(busy_ns, st.sampled_from([10.0, 30.0, 200.0, 333.3]))
def test_deadlines_lie_on_the_grid_and_skipped_ticks_are_counted(
    durations: list[int], frequency_hz: float
) -> None:
    start_ns = 12_345
    rate = Rate(frequency_hz, start_ns)
    now_ns, skipped = start_ns, 0
    for ran, duration in enumerate(durations):
        deadline_ns = rate.deadline_ns
        grid = start_ns + (ran + skipped) * 1e9 / frequency_hz
        assert abs(deadline_ns - grid) <= 1
        now_ns = max(now_ns, deadline_ns) + duration
        rate.advance(now_ns)
        skipped = rate.skipped
        # At most the tick whose period it is may be late: no burst.
        assert now_ns - rate.deadline_ns <= 1e9 / frequency_hz + 1


def test_an_hour_does_not_drift() -> None:
    rate = Rate(200.0, 0)
    for _ in range(720_000):
        rate.advance(rate.deadline_ns)
    assert rate.deadline_ns == 3_600 * 10**9


@pytest.mark.parametrize("frequency_hz", [0.0, -1.0, float("inf"), float("nan")])
def test_a_rate_must_be_positive_and_finite(frequency_hz: float) -> None:
    with pytest.raises(ValueError, match="positive"):
        Rate(frequency_hz, 0)


def test_loop_stats_tell_period_and_busy_time() -> None:
    stats = LoopStats()
    for index in range(4):
        stats.notes += (index * 1000, index * 1000 + 100)
    assert stats.ticks == 4
    assert stats.period.percentile(50) == 1000
    assert stats.busy.percentile(50) == 100
