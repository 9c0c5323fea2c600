"""Whoever chooses payloads, keys, reasons and messages cannot make anything grow."""

import json
import logging
from collections.abc import Iterator

import pytest

from rosbase.contracts.transport import Tally
from rosbase.imu.rejects import REASONS
from rosbase.logger import RosbaseLogger
from rosbase.testing import ManualClock
from rosbase.testing.resources import memory_growth
from support.reader_rig import Rig
from support.samples import FAULTS, GOOD_FRAME

MOST_BYTES = 500_000


@pytest.fixture(autouse=True)
def unheard() -> Iterator[None]:
    """pytest would keep each record, and with it each message."""
    logger = logging.getLogger("rosbase")
    logger.addHandler(logging.NullHandler())
    logger.propagate = False
    yield
    logger.propagate = True


def words(number: int) -> Iterator[str]:
    """Different ones, each of some hundred characters."""
    tail = "".join(chr(code) for code in range(32, 0x3000, 40))
    for n in range(number):
        yield f"{n} \x1b[2J\n{tail}"


def test_what_is_said_once_or_throttled_is_forgotten_again() -> None:
    logger = RosbaseLogger("node", ManualClock())
    with memory_growth() as growth:
        for word in words(5_000):
            logger.log_once(word)
            logger.log_throttle(word, 1e6)
            logger.due(word, 1e6)
        assert growth() < MOST_BYTES


def test_of_many_messages_the_newest_are_still_known() -> None:
    logger = RosbaseLogger("node", ManualClock())
    assert all(logger.due(word, 1e6) for word in words(2_000))
    newest = list(words(2_000))[-900:]
    assert not any(logger.due(word, 1e6) for word in newest)


def test_reasons_that_a_transport_makes_up_are_counted_together() -> None:
    tally = Tally()
    for number in range(10_000):
        tally.count_error(f"made_up_{number}")
    assert len(tally.frame_errors) == 101
    assert sum(tally.frame_errors.values()) == 10_000
    assert tally.frame_errors["other"] == 9_900


def test_a_device_that_sends_every_fault_in_ever_new_words_costs_no_memory() -> None:
    rig = Rig().activate()
    lines = [line for line, _ in FAULTS.values()]

    def send(number: int) -> None:
        for line, word in zip(lines * (number // len(lines)), words(number), strict=False):
            rig.transport.deliver(line, 7)
            rig.transport.deliver(word.encode(errors="replace"), 7)
            rig.transport.deliver(
                json.dumps({word: word, "linear_acceleration": {word: 1}}).encode(), 7
            )
            rig.transport.deliver(GOOD_FRAME.replace(b"9.80665", json.dumps(word).encode()), 7)
        rig.pass_time(60.0)

    send(len(lines) * 5)
    with memory_growth() as growth:
        send(len(lines) * 40)
        assert growth() < MOST_BYTES
    assert set(rig.reader.counts.by_reason) <= set(REASONS)
