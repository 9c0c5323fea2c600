"""Log records of a recorded program."""

import logging
from collections.abc import Iterator

import pytest

from rosbase.entries.kinds import Kind
from rosbase.logger import RosbaseLogger, RosFormatter
from rosbase.testing.recorded_log import RecordedLog
from support.conducted import ConductedProgram, record, replay


@pytest.fixture
def heard() -> Iterator[RecordedLog]:
    log = RecordedLog("program")
    yield log
    log.close()


def lines(log: RecordedLog) -> list[str]:
    """Takes the lines so far, with their dates."""
    found = [RosFormatter().format(record) for record in log.records]
    log.records.clear()
    return found


def test_lines_have_their_recorded_dates_again(heard: RecordedLog) -> None:
    def run(program: ConductedProgram) -> None:
        logger = RosbaseLogger("program")
        program.backend.create_timer(0.25, lambda: logger.info("tick"))
        program.spin(0.6)
        program.see(program.backend.clock.now_ns())

    recorded = record(run)
    said = lines(heard)
    assert said == [
        "[INFO] [1700000000.250000000] [program]: tick",
        "[INFO] [1700000000.500000000] [program]: tick",
    ]
    assert replay(run, recorded) == recorded.seen
    assert lines(heard) == said


def test_a_replay_at_another_level_reads_the_same_dates(heard: RecordedLog) -> None:
    def run(program: ConductedProgram) -> None:
        logger, clock = RosbaseLogger("program"), program.backend.clock

        def tick() -> None:
            logger.debug("more")
            program.see(clock.now())

        program.backend.create_timer(0.1, tick)
        program.spin(0.25)

    logging.getLogger("rosbase.program").setLevel(logging.INFO)
    recorded = record(run)
    assert lines(heard) == []
    logging.getLogger("rosbase.program").setLevel(logging.DEBUG)
    assert replay(run, recorded) == recorded.seen
    assert len(lines(heard)) == 2


def test_a_line_of_another_thread_is_said_again_once(heard: RecordedLog) -> None:
    def run(program: ConductedProgram) -> None:
        program.spin(0.5)
        program.outside(lambda: RosbaseLogger("program").error("lost", exc_info=fault()))
        program.spin(0.1)

    recorded = record(run)
    said = lines(heard)
    assert said[0].splitlines()[0] == "[ERROR] [1700000000.500000000] [program]: lost"
    assert "ValueError: broken" in said[0]
    assert recorded.kinds.count(Kind.LOG) == 1
    replay(run, recorded)
    assert lines(heard) == said


def fault() -> ValueError:
    return ValueError("broken")


def test_after_the_end_nothing_is_heard(heard: RecordedLog) -> None:
    recorded = record(lambda program: program.spin())
    RosbaseLogger("program").info("later")
    assert recorded.kinds.count(Kind.LOG) == 0
    # Not the date of the clock that has ended.
    assert heard.records[0].created > 1_700_000_001
