"""S15: another program reads the same port. It is told from unplugging, named, and read on.

Before, each byte that the other one took was a loss: the port was closed and opened again several
times a second, with two lines in the log each time.
"""

import termios
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from imu_serial.config import SerialConfig
from imu_serial.holders import Process
from imu_serial.port import Port
from imu_serial.rivals import Rivals
from imu_serial.simulator import PtyDevice
from rosbase.contracts.transport import TransportState
from rosbase.errors import TransportError
from support.fast_clock import FastClock
from support.port_holder import hold
from support.serial_rig import SerialRig, wait_for_state
from support.waiting import wait_until


@contextmanager
def sending(rig: SerialRig) -> Iterator[None]:
    """Within it, the device sends a line every two milliseconds."""
    stop = threading.Event()

    def send() -> None:
        while not stop.wait(0.002):
            rig.port.write(b'{"acc":[0.0,0.1,9.8],"gyr":[0.0,0.0,0.5]}\r\n')

    thread = threading.Thread(target=send)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


@pytest.mark.parametrize("reads", ["blocking", "fair", "vmin0"])
def test_s15_another_reader_is_named_once_and_reading_goes_on(
    rig: SerialRig, reads: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    rig.port.plug()
    transport = rig.transport(clock=FastClock())
    # First, because the kernel keeps others out who come later, unless they are root.
    with hold(rig.port.real_path, "screen", reads=reads) as other:
        transport.start(rig.keep)
        opened = len(caplog.messages)
        with sending(rig):
            wait_until(lambda: transport.health.last_error, "the other reader to be noticed")
            said = (
                f"{rig.port.path} is read by process {other.pid} (screen) too: "
                "each byte reaches only one of the two"
            )
            assert transport.health.last_error == said
            # Ten looks more, by its clock.
            deadline = FastClock.monotonic_ns() + 10 * 10**9
            wait_until(lambda: FastClock.monotonic_ns() > deadline, "more looks")
            assert transport.health.last_error == said
    health = transport.health
    assert (health.state, health.reconnects) == (TransportState.CONNECTED, 0)
    # A moment of a busy machine is twenty on this clock, and may be said too.
    assert rig.said(caplog.messages[opened:]) == [said]
    with sending(rig):
        wait_until(lambda: transport.health.last_error == "", "that it is over")
        wait_until(lambda: not rig.frames.empty(), "data")
    assert rig.said(caplog.messages[opened:]) == [said, f"resolved: {said}"]
    transport.close()


def test_s15_unplugging_is_noticed_beside_another_reader(rig: SerialRig) -> None:
    rig.port.plug()
    transport = rig.transport()
    with hold(rig.port.real_path, "screen", reads="fair"):
        transport.start(rig.keep)
        rig.port.unplug()
        wait_for_state(transport, TransportState.RECONNECTING)
    rig.port.plug()
    wait_for_state(transport, TransportState.CONNECTED)
    rig.prove()


def test_s15_one_that_was_there_and_takes_all_shows_in_silence(rig: SerialRig) -> None:
    """A device that sends nothing may be read by somebody else: no read finds anything then."""
    rig.port.plug()
    transport = rig.transport(clock=FastClock())
    with hold(rig.port.real_path, "screen") as other:
        transport.start(rig.keep)
        wait_until(lambda: transport.health.last_error, "the other program to be noticed")
        assert f"process {other.pid} (screen)" in transport.health.last_error


def test_a_silent_device_that_nobody_else_has_is_not_suspected(rig: SerialRig) -> None:
    rig.port.plug()
    transport = rig.transport(clock=FastClock())
    transport.start(rig.keep)
    deadline = FastClock.monotonic_ns() + 5 * 10**9
    wait_until(lambda: FastClock.monotonic_ns() > deadline, "some looks")
    assert transport.health.last_error == ""


@pytest.fixture
def nobody_seen(monkeypatch: pytest.MonkeyPatch) -> list[Process]:
    """Who has the port, as far as this user may see."""
    seen: list[Process] = []
    monkeypatch.setattr("imu_serial.rivals.holder_of", lambda path: seen[0] if seen else None)
    return seen


def test_one_read_in_vain_is_no_other_reader_and_two_are(nobody_seen: list[Process]) -> None:
    rivals = Rivals("/dev/ttyUSB0")
    rivals.note()
    assert rivals.trouble(is_quiet=False) == ""
    rivals.note()
    rivals.note()
    assert "a program that this user may not see" in rivals.trouble(is_quiet=False)
    for _ in range(4):
        assert rivals.trouble(is_quiet=False), "it is not flickering"
    assert rivals.trouble(is_quiet=False) == ""


def test_one_that_goes_on_is_not_said_to_be_over(nobody_seen: list[Process]) -> None:
    rivals = Rivals("/dev/ttyUSB0")
    texts = set()
    for _ in range(30):
        rivals.note()
        rivals.note()
        texts.add(rivals.trouble(is_quiet=False))
    assert len(texts) == 1


def test_one_that_comes_into_sight_or_is_followed_by_another_is_said(
    nobody_seen: list[Process],
) -> None:
    rivals = Rivals("/dev/ttyUSB0")
    names = []
    for name in ("cat", "ModemManager"):
        nobody_seen[:] = [Process(7, name)]
        rivals.note()
        for _ in range(6):
            text = rivals.trouble(is_quiet=False)
        names.append(text)
    assert "process 7 (cat)" in names[0]
    assert "process 7 (ModemManager)" in names[1]
    assert "ID_MM_DEVICE_IGNORE" in names[1]
    nobody_seen.clear()
    texts: list[str] = []
    while not texts or texts[-1]:
        # What it took before it went is nobody else's.
        rivals.note()
        rivals.note()
        texts.append(rivals.trouble(is_quiet=False))
    assert len(texts) <= 5
    assert set(texts) == {names[1], ""}


def test_an_empty_read_is_the_end_only_if_the_line_is_hung_up() -> None:
    """pyserial sets VMIN to 0, for all who have the port: then nothing is an empty read."""
    device = PtyDevice()
    path = str(device.parameters["device_path"])
    port = Port(SerialConfig(path, 115_200))
    settings = termios.tcgetattr(port.fileno())
    settings[6][termios.VMIN] = 0
    termios.tcsetattr(port.fileno(), termios.TCSANOW, settings)
    assert port.read() == b""
    device.write(b"x")
    wait_until(lambda: port.read() == b"x", "the byte")
    assert port.read() == b""
    device.close()
    with pytest.raises(TransportError, match="was lost"):
        port.read()
    port.close()


def test_the_end_of_a_line_is_told_from_a_byte_that_somebody_else_took() -> None:
    device = PtyDevice()
    port = Port(SerialConfig(str(device.parameters["device_path"]), 115_200))
    assert port.read() == b""
    device.write(b"x")
    wait_until(lambda: port.read() == b"x", "the byte")
    device.close()
    with pytest.raises(TransportError, match="was lost"):
        port.read()
    port.close()
