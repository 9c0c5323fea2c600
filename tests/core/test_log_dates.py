"""The dates of records: the machine's, or those of a recorded program's clock."""

import logging
from collections.abc import Iterator
from typing import Any

import pytest

from rosbase.clock import SystemClock
from rosbase.logger import RosbaseLogger, RosFormatter, make_logger
from rosbase.logger.dates import date_by
from rosbase.testing import ManualClock
from rosbase.testing.recorded_log import RecordedLog


@pytest.fixture
def clock() -> Iterator[ManualClock]:
    clock = ManualClock()
    clock.date_ns = 1_234_567_890_250_000_000
    date_by(clock.now_ns)
    yield clock
    date_by(None)


@pytest.fixture
def heard() -> Iterator[RecordedLog]:
    log = RecordedLog("topics")
    yield log
    log.close()


def test_a_record_has_the_date_of_the_clock(clock: ManualClock, heard: RecordedLog) -> None:
    # This one knows nothing of the clock, as the loggers of the bus and of agents.
    RosbaseLogger("topics").info("first")
    clock.advance(0.5)
    RosbaseLogger("topics").info("second")
    assert [RosFormatter().format(record) for record in heard.records] == [
        "[INFO] [1234567890.250000000] [topics]: first",
        "[INFO] [1234567890.750000000] [topics]: second",
    ]


def test_a_logger_of_the_application_hands_on_records_of_that_date(clock: ManualClock) -> None:
    heard: list[logging.LogRecord] = []
    handler: Any = logging.Handler()
    handler.emit = heard.append
    make_logger("own", logging.getLogger, None, handler).warning("here")
    assert [(record.created, record.msecs) for record in heard] == [(1_234_567_890.25, 250.0)]


def test_the_date_is_that_of_the_machine_again(clock: ManualClock, heard: RecordedLog) -> None:
    date_by(None)
    before_ns = SystemClock.now_ns()
    RosbaseLogger("topics").error("now")
    created_s = heard.records[0].created
    # Python has the date from another call of the machine.
    assert before_ns / 1e9 - 1 <= created_s <= SystemClock.now_ns() / 1e9 + 1
