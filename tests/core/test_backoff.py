from random import Random

from hypothesis import given
from hypothesis import strategies as st

from rosbase.runtime.backoff import Backoff


@given(st.floats(0.001, 1), st.floats(1, 100), st.integers(0, 2**32))
def test_delays_grow_to_the_limit_and_jitter_takes_at_most_half(
    first_s: float, limit_s: float, seed: int
) -> None:
    backoff = Backoff(first_s, limit_s, rng=Random(seed))
    expected = first_s
    for _ in range(30):
        delay_s = backoff.next_s()
        assert 0.5 * expected - 1e-9 <= delay_s <= expected + 1e-9
        expected = min(expected * 2.0, limit_s)


def test_reset_begins_again() -> None:
    backoff = Backoff(0.1, 10.0)
    for _ in range(10):
        backoff.next_s()
    backoff.reset()
    assert backoff.next_s() <= 0.1


def test_two_devices_do_not_come_back_in_step() -> None:
    assert Backoff(rng=Random(1)).next_s() != Backoff(rng=Random(2)).next_s()
