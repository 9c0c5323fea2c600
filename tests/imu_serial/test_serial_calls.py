"""open, start, stop and close: in any order, from any thread, and always in time."""

import os
import random
import threading
import time

import pytest

from rosbase.clock import SystemClock
from rosbase.device import STOP_TIMEOUT_S
from rosbase.errors import (
    DeviceBusyError,
    DeviceNotFoundError,
    TransportError,
)
from rosbase.transport import TransportState
from support.serial_port import PluggablePort
from support.serial_rig import SerialRig, elapsed, wait_for_state
from support.waiting import wait_until


@pytest.mark.parametrize("ending", ["stop", "close"])
def test_s6_ending_a_blocked_read_returns_at_once(rig: SerialRig, ending: str) -> None:
    transport = rig.started()
    assert elapsed(getattr(transport, ending)) < 0.5
    assert transport.is_open is (ending == "stop")


def test_s6_ending_while_waiting_for_the_device_returns_at_once(rig: SerialRig) -> None:
    transport = rig.transport(wait=True)
    transport.open()
    transport.start(rig.keep)
    assert elapsed(transport.close) < 0.5
    assert transport.health.state is TransportState.CLOSED


def test_nothing_is_handed_over_once_stop_has_returned(rig: SerialRig) -> None:
    transport = rig.started()
    rig.port.write(b"x\n" * 1000)
    transport.stop()
    handed_over = rig.frames.qsize()
    rig.port.write(b"x\n" * 100)
    transport.start(lambda frame, stamp_ns: None)
    transport.stop()
    assert rig.frames.qsize() == handed_over


def test_all_calls_may_be_made_twice_and_before_any_other(rig: SerialRig) -> None:
    transport = rig.transport()
    transport.stop()
    transport.close()
    rig.port.plug()
    for call in (transport.open, transport.open, transport.stop, transport.stop):
        call()
    transport.start(rig.keep)
    transport.start(rig.keep)
    for call in (transport.close, transport.close, transport.stop, transport.open):
        call()
    assert transport.is_open


def test_start_opens_what_is_not_open_or_says_why_not(rig: SerialRig) -> None:
    transport = rig.transport()
    with pytest.raises(DeviceNotFoundError):
        transport.start(rig.keep)
    rig.port.plug()
    transport.start(rig.keep)
    rig.prove()


def test_it_starts_again_after_stop_and_after_close(rig: SerialRig) -> None:
    transport = rig.started()
    for ending in (transport.stop, transport.close, transport.stop):
        ending()
        transport.start(rig.keep)
        rig.prove()


@pytest.mark.parametrize("ending", ["stop", "close"])
def test_the_calls_may_come_from_within_on_frame(rig: SerialRig, ending: str) -> None:
    rig.port.plug()
    transport = rig.transport()
    called = threading.Event()
    handed_over: list[bytes] = []

    def end(frame: bytes, stamp_ns: int) -> None:
        handed_over.append(frame)
        transport.open()
        getattr(transport, ending)()
        transport.start(end)
        called.set()

    transport.start(end)
    wait_until(lambda: rig.writes(b"a\nb\n") and called.wait(0.05), "on_frame")
    if ending == "close":
        wait_for_state(transport, TransportState.CLOSED)
    assert handed_over == handed_over[:1], "not called again after it asked to end"
    transport.start(rig.keep)
    rig.prove()


def test_an_on_frame_that_hangs_does_not_hang_stop(
    rig: SerialRig, caplog: pytest.LogCaptureFixture
) -> None:
    rig.port.plug()
    transport = rig.transport()
    entered, leave = threading.Event(), threading.Event()

    def hang(frame: bytes, stamp_ns: int) -> None:
        entered.set()
        leave.wait(30)

    transport.start(hang)
    wait_until(lambda: rig.writes(b"x\n") and entered.wait(0.05), "on_frame")
    assert elapsed(transport.close) < STOP_TIMEOUT_S + 1.0
    assert "left behind" in caplog.text
    leave.set()
    # The port is given back by the thread that was left behind.
    other = rig.transport()

    def can_be_opened() -> bool:
        try:
            other.open()
        except DeviceBusyError:
            return False
        return True

    wait_until(can_be_opened, "the port")


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


def test_a_reader_that_fails_is_noticed_and_can_be_started_again(
    rig: SerialRig, caplog: pytest.LogCaptureFixture
) -> None:
    class Clock(SystemClock):
        fails = False

        def now_ns(self) -> int:
            if self.fails:
                raise MemoryError("no more")
            return time.time_ns()

    rig.port.plug()
    clock = Clock()
    transport = rig.transport(clock=clock)
    transport.start(rig.keep)
    rig.prove()
    clock.fails = True
    rig.port.write(b"x\n")
    wait_for_state(transport, TransportState.CLOSED)
    wait_until(lambda: not transport.is_open, "the port to be given back")
    assert "MemoryError" in transport.health.last_error
    assert "the reader failed" in caplog.text
    clock.fails = False
    transport.start(rig.keep)
    rig.prove()


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


def test_any_calls_from_many_threads_end_in_time_and_leak_nothing(rig: SerialRig) -> None:
    rig.port.plug()
    transport = rig.transport()
    slowest: list[float] = []

    def call_at_random(seed: int) -> None:
        choose = random.Random(seed)
        for _ in range(60):
            name = choose.choice(["open", "start", "stop", "close", "health"])
            if name == "health":
                assert transport.health is not None
            elif name == "start":
                slowest.append(elapsed(lambda: transport.start(rig.keep)))
            else:
                slowest.append(elapsed(getattr(transport, name)))
            rig.port.write(b"x\n")

    threads = [threading.Thread(target=call_at_random, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30)
        assert not thread.is_alive()
    assert max(slowest) < STOP_TIMEOUT_S
    transport.close()
    assert transport.health.state is TransportState.CLOSED
