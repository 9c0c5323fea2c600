"""What the contract does not ask of the four calls; the rest is in test_serial_contract.py."""

import os
import threading

import pytest

from rosbase.contracts.transport import TransportState
from rosbase.errors import (
    TransportError,
)
from support.serial_port import PluggablePort
from support.serial_rig import SerialRig, elapsed
from support.waiting import wait_until


def test_s6_ending_while_waiting_for_the_device_returns_at_once(rig: SerialRig) -> None:
    transport = rig.transport(wait=True)
    transport.open()
    transport.start(rig.keep)
    assert elapsed(transport.close) < 0.5
    assert transport.health.state is TransportState.CLOSED


def test_an_on_frame_that_was_left_behind_cannot_end_its_successor(rig: SerialRig) -> None:
    rig.port.plug()
    transport = rig.transport()
    entered, leave, left = threading.Event(), threading.Event(), threading.Event()

    def hang(frame: bytes, stamp_ns: int) -> None:
        entered.set()
        leave.wait(30)
        transport.close()
        transport.stop()
        left.set()

    transport.start(hang)
    wait_until(lambda: rig.writes(b"x\n") and entered.wait(0.05), "on_frame")
    transport.stop()
    # Its own port is given back when it ends; another line is free now.
    (rig.port.path.parent / "other").mkdir()
    other = PluggablePort(rig.port.path.parent / "other")
    other.plug()
    rig.port.path.unlink()
    rig.port.path.symlink_to(other.real_path)
    transport.start(rig.keep)
    leave.set()
    assert left.wait(10)

    def arrives() -> bool:
        other.write(b"proof\n")
        return not rig.frames.empty()

    wait_until(arrives, "a line from the successor")
    transport.close()
    other.unplug()


def test_a_port_is_not_lost_when_no_reader_can_be_made(
    rig: SerialRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_pipe() -> tuple[int, int]:
        raise OSError(24, "Too many open files")

    def no_thread(thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    rig.port.plug()
    transport = rig.transport()
    transport.open()
    with monkeypatch.context() as patch:
        patch.setattr(os, "pipe", no_pipe)
        with pytest.raises(TransportError, match="Too many"):
            transport.start(rig.keep)
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", no_thread)
        with pytest.raises(TransportError, match="new thread"):
            transport.start(rig.keep)
    assert transport.is_open
    transport.start(rig.keep)
    rig.prove()


def test_a_transport_that_waited_and_was_stopped_is_closed(rig: SerialRig) -> None:
    transport = rig.transport(wait=True)
    transport.open()
    transport.start(rig.keep)
    transport.stop()
    assert transport.health.state is TransportState.CLOSED
