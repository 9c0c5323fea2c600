"""Rate and age of a topic."""

import pytest

from rosbase_view.drawing.glyphs import ASCII
from rosbase_view.topic_state import TopicState
from support.viewing import made_topic

SECOND = 1_000_000_000
WINDOW = SECOND // 10


def played(*stamps_ns: int, until_ns: int) -> TopicState:
    """A topic with messages at these times, in windows of a tenth of a second."""
    topic = TopicState(made_topic("/imu"))
    for now_ns in range(WINDOW, until_ns + 1, WINDOW):
        had = [stamp for stamp in stamps_ns if now_ns - WINDOW <= stamp < now_ns]
        topic.count(len(had), 0.1, max(had, default=0), now_ns)
    return topic


def test_nothing_is_known_before_anything_was_counted() -> None:
    topic = TopicState(made_topic("/imu"))
    assert (topic.rate_hz(SECOND), topic.age_ns(SECOND), topic.total) == (None, None, 0)


def test_one_message_has_an_age_and_no_rate() -> None:
    topic = played(SECOND // 2, until_ns=SECOND)
    assert topic.rate_hz(SECOND) is None
    assert topic.age_ns(SECOND) == SECOND // 2
    assert topic.rate_hz(12 * SECOND) == 0.0


@pytest.mark.parametrize("rate_hz", [0.4, 1.0, 7.0, 10.0, 13.0, 200.0])
def test_a_rate_does_not_depend_on_the_windows(rate_hz: float) -> None:
    until_ns = 12 * SECOND
    stamps = [int(n * SECOND / rate_hz) for n in range(int(12 * rate_hz))]
    topic = played(*stamps, until_ns=until_ns)
    assert topic.total == len(stamps)
    assert topic.rate_hz(until_ns) == pytest.approx(rate_hz, rel=1e-6)
    assert topic.age_ns(until_ns) == until_ns - stamps[-1]


def test_a_rate_that_changes_is_that_of_the_last_two_seconds() -> None:
    slow = [n * SECOND // 10 for n in range(50)]
    fast = [5 * SECOND + n * SECOND // 100 for n in range(210)]
    topic = played(*slow, *fast, until_ns=7_100_000_000)
    assert topic.rate_hz(7_100_000_000) == pytest.approx(100.0, rel=0.02)


def test_a_topic_that_falls_silent_grows_old_and_has_no_rate() -> None:
    stamps = [n * SECOND // 100 for n in range(200)]
    topic = played(*stamps, until_ns=4 * SECOND)
    # Not a mean of the time before and the silence.
    assert topic.rate_hz(4 * SECOND) == 0.0
    topic = played(*stamps, until_ns=15 * SECOND)
    assert topic.rate_hz(15 * SECOND) == 0.0
    assert topic.age_ns(15 * SECOND) == 15 * SECOND - stamps[-1]


def test_a_bar_of_the_sparkline_is_half_a_second() -> None:
    topic = TopicState(made_topic("/imu"))
    for number in range(10):
        topic.count(number // 5 + 1, 0.1, SECOND, SECOND)
    assert topic.sparkline.draw(3, ASCII) == " =#"


def test_messages_that_subscriptions_lost_are_added_up() -> None:
    topic = TopicState(made_topic("/imu", subscribers=[1, 2]))
    topic.topic["subscriptions"][1]["dropped"] = 3
    assert topic.dropped == 3
