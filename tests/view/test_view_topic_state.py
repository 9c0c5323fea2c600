"""Rate, age and revision of a topic."""

import pytest

from rosbase_view.drawing.glyphs import ASCII
from rosbase_view.topic_state import TopicState
from support.viewing import made_topic

SECOND = 1_000_000_000


def test_nothing_is_known_before_anything_was_counted() -> None:
    topic = TopicState(made_topic("/imu"))
    assert (topic.rate_hz, topic.age_ns(SECOND), topic.total) == (None, None, 0)


def test_a_fast_topic_has_the_rate_of_its_last_second() -> None:
    topic = TopicState(made_topic("/imu"))
    for number in range(50):
        topic.count(10, 0.1, number * SECOND // 10)
    for number in range(11):
        topic.count(20, 0.1, (50 + number) * SECOND // 10)
    assert topic.rate_hz == pytest.approx(200.0)
    assert topic.total == 720


def test_a_slow_topic_has_the_rate_of_ten_seconds() -> None:
    topic = TopicState(made_topic("/map"))
    for number in range(300):
        topic.count(1 if number % 50 == 0 else 0, 0.1, number * SECOND // 10)
    assert topic.rate_hz == pytest.approx(0.2, rel=0.1)


def test_a_topic_that_falls_silent_grows_old_and_its_rate_falls_to_zero() -> None:
    topic = TopicState(made_topic("/imu"))
    topic.count(20, 0.1, SECOND)
    for number in range(110):
        topic.count(0, 0.1, SECOND + (number + 1) * SECOND // 10)
    assert topic.rate_hz == 0.0
    assert topic.age_ns(12 * SECOND) == 11 * SECOND


def test_a_silent_topic_needs_no_new_row() -> None:
    topic = TopicState(made_topic("/imu"))
    topic.count(0, 0.1, SECOND)
    before = topic.revision
    topic.count(0, 0.1, 2 * SECOND)
    topic.learn(made_topic("/imu"))
    assert topic.revision == before
    topic.learn(made_topic("/imu", subscribers=[1]))
    assert topic.revision == before + 1


def test_a_bar_of_the_sparkline_is_half_a_second() -> None:
    topic = TopicState(made_topic("/imu"))
    for number in range(10):
        topic.count(number // 5 + 1, 0.1, SECOND)
    assert topic.sparkline.draw(3, ASCII) == " =#"
