"""A device goes wrong when a test says so, and what is built on DeviceTransport bears it."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from rosbase.clock import SystemClock
from rosbase.contracts.transport import Transport, TransportContext, TransportState
from rosbase.device import DeviceTransport
from rosbase.errors import DeviceBusyError
from rosbase.framing import LineFramer
from rosbase.logger import RosbaseLogger
from rosbase.testing import Faults, RecordingSubscriber
from support.fifo import FifoDevice, FifoPeer
from support.waiting import wait_until


class Rig:
    """A device with faults, a transport on it, and what comes through."""

    def __init__(self, folder: Path) -> None:
        self.peer = FifoPeer(folder)
        self.faults = Faults(lambda: FifoDevice(str(self.peer.path)))
        context = TransportContext(SystemClock(), RosbaseLogger("faults"))
        self.transport: Transport = DeviceTransport(
            self.faults.open, context, framer=LineFramer(), waits_for_device=True
        )
        self.subscriber = RecordingSubscriber()


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path)
    yield rig
    rig.transport.close()
    rig.peer.close()


def test_short_reads_give_the_same_frames(rig: Rig) -> None:
    rig.faults.most_bytes = 3
    rig.transport.start(rig.subscriber)
    rig.peer.send_raw(b"one two three\nfour five six\n")
    assert rig.subscriber.wait_for(2)
    assert rig.subscriber.frames == [b"one two three", b"four five six"]


def test_a_device_that_is_lost_is_opened_again(rig: Rig) -> None:
    rig.transport.start(rig.subscriber)
    rig.faults.lose()
    wait_until(lambda: rig.transport.health.reconnects == 1, "the device to be back")
    rig.peer.send(b"good")
    assert rig.subscriber.wait_for_frame(b"good")


def test_a_read_that_raises_ends_the_reader_which_is_noticed(rig: Rig) -> None:
    rig.transport.start(rig.subscriber)
    rig.faults.raise_error(ValueError("a fault of the library"))
    wait_until(lambda: rig.transport.health.state is TransportState.CLOSED, "the end")
    wait_until(lambda: not rig.transport.is_open, "the device to be given back")
    assert "a fault of the library" in rig.transport.health.last_error


def test_junk_costs_the_line_that_it_touches(rig: Rig) -> None:
    rig.transport.start(rig.subscriber)
    rig.faults.disturb(b"\xff\xff\n")
    assert rig.subscriber.wait_for(1)
    rig.peer.send(b"good")
    assert rig.subscriber.wait_for(2)
    assert rig.subscriber.frames == [b"\xff\xff", b"good"]


def test_a_device_that_cannot_be_opened_is_waited_for(rig: Rig) -> None:
    rig.faults.refusal = DeviceBusyError("in use")
    rig.transport.start(rig.subscriber)
    assert rig.transport.health.state is TransportState.RECONNECTING
    rig.faults.refusal = None
    wait_until(lambda: rig.transport.is_open, "the device")
    rig.peer.send(b"good")
    assert rig.subscriber.wait_for_frame(b"good")
