"""What becomes of the answer of `on_frame`."""

from typing import Any

import pytest

from rosbase.contracts.transport import hand_over
from rosbase.logger import RosbaseLogger
from rosbase.testing import RecordingSubscriber


def answered(answer: Any) -> bool:
    return hand_over(lambda frame, stamp_ns: answer, b"x", 1, RosbaseLogger("test"))


def test_the_answer_says_whether_a_sample_came_of_the_frame() -> None:
    assert answered(True)
    assert not answered(False)


@pytest.mark.parametrize("answer", [None, 0, 1, "", "no", [], 0.0])
def test_an_answer_that_is_none_of_both_counts_as_a_sample(answer: object) -> None:
    assert answered(answer)


@pytest.mark.parametrize("error", [ValueError("no good"), SystemExit(3), KeyboardInterrupt()])
def test_of_a_frame_on_which_on_frame_raises_no_sample_came(
    error: BaseException, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(frame: bytes, stamp_ns: int) -> bool:
        raise error

    logger = RosbaseLogger("test")
    assert not any(hand_over(fail, b"x", 1, logger) for _ in range(10))
    assert len(caplog.records) == 1


def test_a_recording_subscriber_answers_as_it_is_told() -> None:
    assert RecordingSubscriber()(b"x", 1) is None
    assert RecordingSubscriber(then=lambda frame, stamp_ns: frame == b"x")(b"x", 1) is True
    assert RecordingSubscriber(then=lambda frame, stamp_ns: frame == b"x")(b"y", 1) is False
