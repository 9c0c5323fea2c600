"""What comes over the line is handed over as it should be."""

import sys
import time
from typing import Any

import pytest

from support.serial_rig import SerialRig
from support.waiting import wait_until


def test_lines_come_through_whole_and_in_order(rig: SerialRig) -> None:
    transport = rig.started()
    rig.port.write(b"".join(b"%d\r\n" % number for number in range(5000)))
    assert [int(rig.next()) for _ in range(5000)] == list(range(5000))
    assert transport.health.frame_errors == {}


def test_the_stamp_is_taken_when_the_first_bytes_were_read(rig: SerialRig) -> None:
    transport = rig.started()
    seen = transport.health.received_bytes
    before_ns = time.time_ns()
    rig.port.write(b'{"begun":')
    wait_until(lambda: transport.health.received_bytes > seen, "the first half")
    between_ns = time.time_ns()
    rig.port.write(b"1}\n")
    frame, stamp_ns = rig.frames.get(timeout=20)
    assert frame == b'{"begun":1}'
    assert before_ns <= stamp_ns <= between_ns


def test_start_discards_what_the_device_sent_before(rig: SerialRig) -> None:
    rig.port.plug()
    transport = rig.transport()
    transport.open()
    rig.port.write(b"stale\n" * 10)
    transport.start(rig.keep)
    rig.prove()
    transport.stop()
    assert rig.frames.empty()


def test_an_exception_in_on_frame_is_logged_and_the_stream_goes_on(
    rig: SerialRig, caplog: pytest.LogCaptureFixture
) -> None:
    rig.port.plug()
    transport = rig.transport()

    def pick(frame: bytes, stamp_ns: int) -> None:
        if frame == b"bad":
            raise ValueError("no good")
        rig.keep(frame, stamp_ns)

    transport.start(pick)
    rig.prove()
    rig.port.write(b"bad\n" * 50 + b"good\n")
    assert rig.next() == b"good"
    errors: list[Any] = [record for record in caplog.records if record.levelname == "ERROR"]
    assert len(errors) == 1
    assert errors[0].exc_info[1].args == ("no good",)


def test_an_on_frame_that_exits_does_not_end_the_stream(
    rig: SerialRig, caplog: pytest.LogCaptureFixture
) -> None:
    rig.port.plug()
    transport = rig.transport()

    def leave(frame: bytes, stamp_ns: int) -> None:
        rig.keep(frame, stamp_ns)
        if frame == b"exit":
            sys.exit(3)

    transport.start(leave)
    rig.prove()
    rig.port.write(b"exit\nnext\n")
    assert [rig.next(), rig.next()] == [b"exit", b"next"]
    assert "SystemExit" in caplog.text
