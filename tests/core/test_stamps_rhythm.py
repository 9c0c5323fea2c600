"""What a stream's usual interval is, whatever happens now and then."""

from collections.abc import Iterable
from itertools import chain, repeat

import pytest

from rosbase.stamps import Rhythm

MS = 1_000_000


def heard(waits_ms: Iterable[float | tuple[float, int]], rhythm: Rhythm | None = None) -> Rhythm:
    """A rhythm that has heard of frames after such waits; several at once, where there are two."""
    rhythm, at_ns = rhythm or Rhythm(), 0
    rhythm.add(1, at_ns)
    for wait in waits_ms:
        wait_ms, count = wait if isinstance(wait, tuple) else (wait, 1)
        at_ns += round(wait_ms * MS)
        rhythm.add(count, at_ns)
    return rhythm


def test_it_is_known_after_nine_arrivals() -> None:
    assert heard([10.0] * 7).interval_ns == 0
    rhythm = heard([10.0] * 8)
    assert (rhythm.interval_ns, rhythm.jitter_ns) == (10 * MS, 0)


@pytest.mark.parametrize("place", range(8))
def test_the_pause_before_a_device_begins_does_not_count(place: int) -> None:
    waits = [10.0] * 8
    waits[place] = 5_000.0
    assert heard(waits).interval_ns == 10 * MS


@pytest.mark.parametrize(
    ("waits", "usual_ms"),
    [
        ([(16.0, 2), (16.0, 1), (16.0, 2), (16.0, 1), (16.0, 2)] * 40, 10.0),
        ([(50.0, 2)] * 100, 25.0),
        ([(200.0, 2)] * 100, 100.0),
        # Two lines in one write, read one by one.
        ([49.9, 0.1] * 100, 25.0),
        ([(100.0, 10)] * 30, 10.0),
        # A network that holds some messages up, and then brings them at once.
        (chain(*repeat([10.0] * 6 + [38.0, 0.1, 0.1, 1.8], 20)), 10.0),
    ],
)
def test_it_is_the_mean_of_what_comes_in_groups(
    waits: Iterable[float | tuple[float, int]], usual_ms: float
) -> None:
    assert heard(waits).interval_ns / MS == pytest.approx(usual_ms, rel=0.08)


def test_a_pause_changes_little() -> None:
    rhythm = heard([*[10.0] * 50, 60_000.0])
    assert rhythm.interval_ns / MS < 11.0
    rhythm = heard([*[10.0] * 50, 60_000.0, *[10.0] * 200])
    assert rhythm.interval_ns / MS == pytest.approx(10.0, rel=0.01)


@pytest.mark.parametrize(("before_ms", "after_ms"), [(10.0, 100.0), (100.0, 10.0), (5.0, 10.0)])
def test_a_new_rate_is_learned(before_ms: float, after_ms: float) -> None:
    rhythm = heard([*[before_ms] * 100, *[after_ms] * 400])
    assert rhythm.interval_ns / MS == pytest.approx(after_ms, rel=0.05)


def test_the_jitter_is_how_far_from_the_interval_frames_arrive() -> None:
    assert heard([8.0, 12.0] * 100).jitter_ns / MS == pytest.approx(2.0, rel=0.1)
    assert heard([*[8.0, 12.0] * 50, *[10.0] * 200]).jitter_ns < MS // 10


def test_a_pause_that_is_known_of_does_not_count_at_all() -> None:
    rhythm = heard([10.0] * 50)
    rhythm.pause()
    rhythm.add(1, 3_600_000 * MS)
    rhythm.add(1, 3_600_010 * MS)
    assert rhythm.interval_ns == 10 * MS


def test_arrivals_at_one_moment_say_nothing() -> None:
    assert heard([0.0] * 100).interval_ns == 0
