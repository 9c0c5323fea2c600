from hypothesis import given
from hypothesis import strategies as st

from rosbase.runtime.histogram import Histogram

values = st.lists(st.integers(0, 2**50), min_size=1, max_size=200)


@given(values, st.floats(1, 100))
def test_a_percentile_is_at_most_one_thirtysecond_above_the_true_one(
    recorded: list[int], percent: float
) -> None:
    histogram = Histogram()
    for value in recorded:
        histogram.record(value)
    rank = -(-percent * len(recorded) // 100)
    true = sorted(recorded)[max(0, int(rank) - 1)]
    assert true <= histogram.percentile(percent) <= true + true // 32 + 1


def test_an_empty_histogram_says_nothing() -> None:
    assert Histogram().percentile(99) == 0


def test_absurd_values_are_counted_too() -> None:
    histogram = Histogram()
    histogram.record(-5)
    histogram.record(2**200)
    assert histogram.count == 2
    assert histogram.percentile(1) == 0


@given(values)
def test_buckets_count_every_value_and_the_first_one_has_the_least(recorded: list[int]) -> None:
    histogram = Histogram()
    histogram.record_all(recorded)
    buckets = histogram.buckets()
    assert sum(count for _, count in buckets) == len(recorded)
    assert [upper for upper, _ in buckets] == sorted({upper for upper, _ in buckets})
    least = min(recorded)
    assert least - least // 32 - 1 <= histogram.minimum() <= least
    assert histogram.minimum() <= least <= buckets[0][0]


def test_an_empty_histogram_has_no_buckets() -> None:
    assert Histogram().buckets() == []
    assert Histogram().minimum() == 0
