"""The transport on a real line. The names S1 to S13 are those of the faults in its README."""

import os
import queue
import random
import resource
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from imu_serial.config import SerialConfig
from imu_serial.port import Port
from imu_serial.transport import STOP_TIMEOUT_S, SerialTransport
from rosbase.clock import SystemClock
from rosbase.errors import (
    DeviceBusyError,
    DeviceNotFoundError,
    DevicePermissionError,
    NotADeviceError,
    TransportError,
)
from rosbase.logger import RosbaseLogger
from rosbase.transport import TransportContext, TransportState
from support.serial_port import PluggablePort
from support.waiting import wait_until


class Rig:
    """A port, a transport on it, and the frames that came through."""

    def __init__(self, folder: Path) -> None:
        self.port = PluggablePort(folder)
        self.frames: queue.Queue[tuple[bytes, int]] = queue.Queue()
        self.made: list[SerialTransport] = []

    def transport(self, *, wait: bool = False, path: Path | None = None) -> SerialTransport:
        config = SerialConfig(str(path or self.port.path), 115_200, wait)
        context = TransportContext(SystemClock(), RosbaseLogger("serial_test"))
        self.made.append(SerialTransport(config, context))
        return self.made[-1]

    def keep(self, frame: bytes, stamp_ns: int) -> None:
        self.frames.put((frame, stamp_ns))

    def writes(self, data: bytes) -> bool:
        self.port.write(data)
        return True

    def next(self) -> bytes:
        return self.frames.get(timeout=20)[0]

    def started(self) -> SerialTransport:
        """A transport that has proved to read."""
        self.port.plug()
        transport = self.transport()
        transport.open()
        transport.start(self.keep)
        self.prove()
        return transport

    def prove(self) -> None:
        """Writes until the reader, which first discards what is old, hands something over."""

        def arrived() -> bool:
            self.port.write(b"proof\n")
            try:
                return self.frames.get(timeout=0.05)[0] == b"proof"
            except queue.Empty:
                return False

        wait_until(arrived, "a line to come through")
        self.port.write(b"last\n")
        wait_until(lambda: self.next() == b"last", "the last proof")


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path)
    yield rig
    for transport in rig.made:
        transport.close()
    rig.port.unplug()


def state(transport: SerialTransport, wanted: TransportState) -> None:
    wait_until(lambda: transport.health.state is wanted, f"state {wanted}")


def elapsed(call: Callable[[], object]) -> float:
    start = time.monotonic()
    call()
    return time.monotonic() - start


def test_lines_come_through_whole_and_in_order(rig: Rig) -> None:
    transport = rig.started()
    rig.port.write(b"".join(b"%d\r\n" % number for number in range(5000)))
    assert [int(rig.next()) for _ in range(5000)] == list(range(5000))
    assert transport.health.frame_errors == {}


def test_the_stamp_is_taken_when_the_first_bytes_were_read(rig: Rig) -> None:
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


def test_start_discards_what_the_device_sent_before(rig: Rig) -> None:
    rig.port.plug()
    transport = rig.transport()
    transport.open()
    rig.port.write(b"stale\n" * 10)
    transport.start(rig.keep)
    rig.prove()
    transport.stop()
    assert rig.frames.empty()


# S1: absent at the start.


def test_s1_an_absent_port_is_refused_in_one_line(rig: Rig) -> None:
    transport = rig.transport()
    with pytest.raises(DeviceNotFoundError, match="is not there; is the device plugged in") as e:
        transport.open()
    assert "\n" not in str(e.value)
    assert not transport.is_open
    assert transport.health.state is TransportState.CLOSED


def test_s1_an_absent_port_is_waited_for_and_picked_up_when_it_comes(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    transport = rig.transport(wait=True)
    transport.open()
    transport.open()
    assert transport.health.state is TransportState.RECONNECTING
    transport.start(rig.keep)
    transport.start(rig.keep)
    rig.port.plug()
    state(transport, TransportState.CONNECTED)
    rig.prove()
    assert len(caplog.records) == 1, "one line for one change of state"
    assert transport.health.reconnects == 0, "it came late, it did not come back"


# S2 and S3: unplugged while reading, and replugged.


def test_s2_s3_an_unplugged_port_is_taken_again_when_it_is_back(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    transport = rig.started()
    for times in range(1, 6):
        rig.port.unplug()
        state(transport, TransportState.RECONNECTING)
        assert not transport.is_open
        assert transport.health.last_error
        rig.port.plug()
        back_s = elapsed(lambda: state(transport, TransportState.CONNECTED))
        assert back_s < 2.0
        rig.prove()
        assert transport.health.reconnects == times
    lost = [m for m in caplog.messages if "was lost" in m]
    assert len(lost) == 5
    assert len(caplog.messages) <= 1 + 5 * 3, "lost, not there, is back"


def test_a_frame_begun_before_the_loss_is_not_continued_after_it(rig: Rig) -> None:
    transport = rig.started()
    seen = transport.health.received_bytes
    rig.port.write(b'{"half":')
    wait_until(lambda: transport.health.received_bytes > seen, "the first half")
    rig.port.unplug()
    state(transport, TransportState.RECONNECTING)
    rig.port.plug()
    state(transport, TransportState.CONNECTED)
    rig.prove()
    assert rig.frames.empty()


# S6: stop and close while the reader blocks; any order, any thread.


@pytest.mark.parametrize("ending", ["stop", "close"])
def test_s6_ending_a_blocked_read_returns_at_once(rig: Rig, ending: str) -> None:
    transport = rig.started()
    assert elapsed(getattr(transport, ending)) < 0.5
    assert transport.is_open is (ending == "stop")


def test_s6_ending_while_waiting_for_the_device_returns_at_once(rig: Rig) -> None:
    transport = rig.transport(wait=True)
    transport.open()
    transport.start(rig.keep)
    assert elapsed(transport.close) < 0.5
    assert transport.health.state is TransportState.CLOSED


def test_nothing_is_handed_over_once_stop_has_returned(rig: Rig) -> None:
    transport = rig.started()
    rig.port.write(b"x\n" * 1000)
    transport.stop()
    handed_over = rig.frames.qsize()
    rig.port.write(b"x\n" * 100)
    transport.start(lambda frame, stamp_ns: None)
    transport.stop()
    assert rig.frames.qsize() == handed_over


def test_all_calls_may_be_made_twice_and_before_any_other(rig: Rig) -> None:
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


def test_start_opens_what_is_not_open_or_says_why_not(rig: Rig) -> None:
    transport = rig.transport()
    with pytest.raises(DeviceNotFoundError):
        transport.start(rig.keep)
    rig.port.plug()
    transport.start(rig.keep)
    rig.prove()


def test_it_starts_again_after_stop_and_after_close(rig: Rig) -> None:
    transport = rig.started()
    for ending in (transport.stop, transport.close, transport.stop):
        ending()
        transport.start(rig.keep)
        rig.prove()


@pytest.mark.parametrize("ending", ["stop", "close"])
def test_the_calls_may_come_from_within_on_frame(rig: Rig, ending: str) -> None:
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
        state(transport, TransportState.CLOSED)
    assert handed_over == handed_over[:1], "not called again after it asked to end"
    transport.start(rig.keep)
    rig.prove()


def test_an_on_frame_that_hangs_does_not_hang_stop(
    rig: Rig, caplog: pytest.LogCaptureFixture
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


def test_an_on_frame_that_was_left_behind_cannot_end_its_successor(rig: Rig) -> None:
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
    transport._config = SerialConfig(str(other.path), 115_200)
    transport.start(rig.keep)
    leave.set()
    assert left.wait(10)

    def arrives() -> bool:
        other.write(b"proof\n")
        return not rig.frames.empty()

    wait_until(arrives, "a line from the successor")
    transport.close()
    other.unplug()


def test_an_on_frame_that_exits_does_not_end_the_stream(
    rig: Rig, caplog: pytest.LogCaptureFixture
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


def test_a_reader_that_fails_is_noticed_and_can_be_started_again(
    rig: Rig, caplog: pytest.LogCaptureFixture
) -> None:
    class Clock(SystemClock):
        fails = False

        def now_ns(self) -> int:
            if self.fails:
                raise MemoryError("no more")
            return time.time_ns()

    rig.port.plug()
    clock = Clock()
    context = TransportContext(clock, RosbaseLogger("serial_test"))
    transport = SerialTransport(SerialConfig(str(rig.port.path), 115_200), context)
    rig.made.append(transport)
    transport.start(rig.keep)
    rig.prove()
    clock.fails = True
    rig.port.write(b"x\n")
    state(transport, TransportState.CLOSED)
    wait_until(lambda: not transport.is_open, "the port to be given back")
    assert "MemoryError" in transport.health.last_error
    assert "the reader failed" in caplog.text
    clock.fails = False
    transport.start(rig.keep)
    rig.prove()


def test_a_port_is_not_lost_when_no_reader_can_be_made(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
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
        with pytest.raises(OSError, match="Too many"):
            transport.start(rig.keep)
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", no_thread)
        with pytest.raises(RuntimeError, match="new thread"):
            transport.start(rig.keep)
    assert transport.is_open
    transport.start(rig.keep)
    rig.prove()


def test_a_transport_that_waited_and_was_stopped_is_closed(rig: Rig) -> None:
    transport = rig.transport(wait=True)
    transport.open()
    transport.start(rig.keep)
    transport.stop()
    assert transport.health.state is TransportState.CLOSED


def test_any_calls_from_many_threads_end_in_time_and_leak_nothing(rig: Rig) -> None:
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


# S8 to S11: what comes over the line.


def test_s8_s9_boot_text_and_any_line_ending_resynchronise_at_the_next_line(rig: Rig) -> None:
    rig.started()
    rig.port.write(b'part of a line"}\r\n\x00\x00ets Jul 29 2019\r\n\r\n\n')
    rig.port.write(b'{"a":1}\r{"a":2}\n\x00{"a":3}\r\n')
    assert [rig.next() for _ in range(5)] == [
        b'part of a line"}',
        b"ets Jul 29 2019",
        b'{"a":1}',
        b'{"a":2}',
        b'{"a":3}',
    ]


def test_s10_noise_does_not_harm_the_lines_after_it(rig: Rig) -> None:
    rig.started()
    noise = random.Random(10).randbytes(200_000)
    rig.port.write(noise + b'\n{"a":1}\n')
    wait_until(lambda: rig.next() == b'{"a":1}', "the line after the noise")


def test_s11_without_a_newline_memory_is_bounded_and_the_loss_is_counted(rig: Rig) -> None:
    transport = rig.started()
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(100):
        rig.port.write(b"x" * 100_000)
    rig.port.write(b'\n{"a":1}\n')
    assert rig.next() == b'{"a":1}'
    assert transport.health.frame_errors == {"overlong": 1}
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kb < 8_000


# S12: more than can be handled.


def test_s12_a_flood_can_be_stopped(rig: Rig) -> None:
    transport = rig.started()
    stop = threading.Event()

    def flood() -> None:
        while not stop.is_set():
            try:
                rig.port.write(b'{"a":1}\n' * 500)
            except TransportError:
                return

    thread = threading.Thread(target=flood)
    thread.start()
    wait_until(lambda: transport.health.frames > 5000, "the flood")
    assert elapsed(transport.close) < 0.5
    stop.set()
    rig.port.unplug()
    thread.join(10)
    assert not thread.is_alive()


# S13: what cannot be opened, and why.

AS_NOBODY = """
import os, sys
from imu_serial.config import SerialConfig
from imu_serial.port import Port
from imu_serial.port import Port
if os.getuid() == 0:
    os.setuid(65534)
try:
    {attempt}
except Exception as error:
    print(type(error).__name__, error)
"""


def as_nobody(attempt: str) -> str:
    """What an attempt ends with for a user without privileges."""
    shown = subprocess.run(
        [sys.executable, "-c", AS_NOBODY.format(attempt=attempt)],
        capture_output=True,
        text=True,
        timeout=30,
        check=True,
    )
    return shown.stdout.strip()


def test_s13_permission_denied_names_the_group(rig: Rig) -> None:
    rig.port.plug()
    os.chmod(rig.port.real_path, 0)
    shown = as_nobody(f"Port(SerialConfig({rig.port.real_path!r}, 9600))")
    assert shown.startswith(f"{DevicePermissionError.__name__} {rig.port.real_path}")
    assert "it belongs to the group" in shown


def test_s13_a_busy_port_is_refused_and_free_again_after_close(rig: Rig) -> None:
    rig.port.plug()
    first, second = rig.transport(), rig.transport()
    first.open()
    with pytest.raises(DeviceBusyError, match="in use by another program"):
        second.open()
    first.close()
    second.open()


def test_s13_programs_that_ask_for_no_lock_are_kept_out_too(rig: Rig) -> None:
    rig.port.plug()
    os.chmod(rig.port.real_path, 0o666)
    attempt = f"os.open({rig.port.real_path!r}, os.O_RDWR | os.O_NOCTTY)"
    transport = rig.transport()
    transport.open()
    assert "Device or resource busy" in as_nobody(attempt)
    transport.close()
    assert as_nobody(attempt) == ""


@pytest.mark.parametrize("path", ["", "/dev/a\0b", "/dev/a\nb"])
def test_s13_a_name_that_can_be_none_is_one_line(path: str) -> None:
    with pytest.raises(TransportError) as caught:
        Port(SerialConfig(path, 9600))
    assert "\n" not in str(caught.value)
    assert "\0" not in str(caught.value)


@pytest.mark.parametrize("what", ["directory", "file", "null", "under a file"])
def test_s13_what_is_no_serial_port_is_said_and_not_waited_for(
    rig: Rig, tmp_path: Path, what: str
) -> None:
    file = tmp_path / "file"
    file.write_text("x")
    paths = {
        "directory": tmp_path,
        "file": file,
        "null": Path("/dev/null"),
        "under a file": file / "tty",
    }
    with pytest.raises(NotADeviceError, match="not a serial port") as caught:
        rig.transport(wait=True, path=paths[what]).open()
    assert "\n" not in str(caught.value)


def test_an_exception_in_on_frame_is_logged_and_the_stream_goes_on(
    rig: Rig, caplog: pytest.LogCaptureFixture
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
