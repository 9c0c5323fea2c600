"""Where a recording is while it is played."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase_view.recorded.playhead import Playhead

S = 1_000_000_000
BEGIN, END = 100 * S, 200 * S


def test_it_stands_at_the_beginning_until_it_is_played() -> None:
    head = Playhead(BEGIN, END)
    assert head.at(7 * S) == BEGIN
    head.play(10 * S)
    assert head.at(10 * S) == BEGIN
    assert head.at(13 * S) == BEGIN + 3 * S
    head.pause(14 * S)
    assert head.at(99 * S) == BEGIN + 4 * S
    head.play(100 * S)
    assert head.at(101 * S) == BEGIN + 5 * S


def test_another_speed_goes_on_from_there() -> None:
    head = Playhead(BEGIN, END)
    head.play(0)
    head.set_rate(2.0, 10 * S)
    assert head.at(10 * S) == BEGIN + 10 * S
    assert head.at(11 * S) == BEGIN + 12 * S
    assert head.due_ns(BEGIN + 16 * S, 11 * S) == 2 * S
    assert head.due_ns(BEGIN, 11 * S) == 0


@pytest.mark.parametrize("rate", [0.0, -1.0, float("nan"), float("inf")])
def test_no_speed_is_refused(rate: float) -> None:
    with pytest.raises(ValueError, match="greater than 0"):
        Playhead(BEGIN, END).set_rate(rate, 0)


@pytest.mark.parametrize(
    ("asked", "found"), [(BEGIN + S, BEGIN + S), (BEGIN - S, BEGIN), (END + S, END)]
)
def test_a_jump_ends_within_the_recording(asked: int, found: int) -> None:
    head = Playhead(BEGIN, END)
    head.play(0)
    head.seek(asked, 5 * S)
    assert head.at(5 * S) == found
    assert head.is_playing


_STEPS = st.lists(
    st.tuples(
        st.sampled_from(["play", "pause", "seek", "rate"]),
        st.integers(0, 300 * S),
        st.floats(0.01, 100.0),
    )
)


@given(_STEPS)
def test_whatever_is_asked_it_stays_within_the_recording_and_never_goes_back(steps: list) -> None:  # type: ignore[type-arg]  # of three kinds
    head, now = Playhead(BEGIN, END), 0
    for what, time_ns, rate in steps:
        before = head.at(now)
        now += time_ns // 10
        assert before <= head.at(now) <= END
        if what == "play":
            head.play(now)
        elif what == "pause":
            head.pause(now)
        elif what == "rate":
            head.set_rate(rate, now)
        else:
            head.seek(time_ns, now)
        assert BEGIN <= head.at(now) <= END
