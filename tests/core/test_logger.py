import logging

import pytest

from rosbase.logger import RosbaseLogger
from rosbase.testing import ManualClock


@pytest.fixture
def records(caplog: pytest.LogCaptureFixture) -> pytest.LogCaptureFixture:
    logging.getLogger("rosbase").propagate = True
    caplog.set_level(logging.DEBUG, logger="rosbase")
    return caplog


def test_once_means_once_until_reset(records: pytest.LogCaptureFixture) -> None:
    logger = RosbaseLogger("node")
    for _ in range(3):
        logger.info("hello", once=True)
        logger.log_once("hello", "warning")
    assert [r.levelname for r in records.records] == ["INFO", "WARNING"]
    logger.reset()
    logger.info("hello", once=True)
    assert len(records.records) == 3


def test_the_throttle_runs_on_the_monotonic_clock(records: pytest.LogCaptureFixture) -> None:
    clock = ManualClock()
    logger = RosbaseLogger("node", clock)
    for _ in range(10):
        logger.log_throttle("again", 2.0)
        clock.date_ns += 3_600 * 10**9
        clock.advance(0.5)
    assert len(records.records) == 3


def test_messages_keep_their_percent_signs(records: pytest.LogCaptureFixture) -> None:
    RosbaseLogger("node").important("100 % done")
    assert records.messages == ["*** 100 % done ***"]


def test_an_unknown_level_is_refused() -> None:
    with pytest.raises(ValueError, match="loud"):
        RosbaseLogger("node").important("x", "loud")
