"""S1 to S13, as the README of imu-serial numbers them; S2, S3, S6 and S11 are in the contract."""

import os
import random
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from imu_serial.config import SerialConfig
from imu_serial.port import Port
from rosbase.contracts.transport import TransportState
from rosbase.errors import (
    DeviceBusyError,
    DeviceNotFoundError,
    DevicePermissionError,
    NotADeviceError,
    TransportError,
)
from support.serial_rig import SerialRig, elapsed, wait_for_state
from support.waiting import wait_until

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


def test_s1_an_absent_port_is_refused_in_one_line(rig: SerialRig) -> None:
    transport = rig.transport()
    with pytest.raises(DeviceNotFoundError, match="is not there; is the device plugged in") as e:
        transport.open()
    assert "\n" not in str(e.value)
    assert not transport.is_open
    assert transport.health.state is TransportState.CLOSED


def test_s1_an_absent_port_is_waited_for_and_picked_up_when_it_comes(
    rig: SerialRig, caplog: pytest.LogCaptureFixture
) -> None:
    transport = rig.transport(wait=True)
    transport.open()
    transport.open()
    assert transport.health.state is TransportState.RECONNECTING
    transport.start(rig.keep)
    transport.start(rig.keep)
    rig.port.plug()
    wait_for_state(transport, TransportState.CONNECTED)
    rig.prove()
    assert len(caplog.records) == 1, "one line for one change of state"
    assert transport.health.reconnects == 0, "it came late, it did not come back"


def test_s8_s9_boot_text_and_any_line_ending_resynchronise_at_the_next_line(rig: SerialRig) -> None:
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


def test_s10_noise_does_not_harm_the_lines_after_it(rig: SerialRig) -> None:
    rig.started()
    noise = random.Random(10).randbytes(200_000)
    rig.port.write(noise + b'\n{"a":1}\n')
    wait_until(lambda: rig.next() == b'{"a":1}', "the line after the noise")


def test_s12_a_flood_can_be_stopped(rig: SerialRig) -> None:
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


def test_s13_permission_denied_names_the_group(rig: SerialRig) -> None:
    rig.port.plug()
    os.chmod(rig.port.real_path, 0)
    shown = as_nobody(f"Port(SerialConfig({rig.port.real_path!r}, 9600))")
    assert shown.startswith(f"{DevicePermissionError.__name__} {rig.port.real_path}")
    assert "it belongs to the group" in shown


def test_s13_a_busy_port_is_refused_and_free_again_after_close(rig: SerialRig) -> None:
    rig.port.plug()
    first, second = rig.transport(), rig.transport()
    first.open()
    with pytest.raises(DeviceBusyError, match="in use by another program"):
        second.open()
    first.close()
    second.open()


def test_s13_programs_that_ask_for_no_lock_are_kept_out_too(rig: SerialRig) -> None:
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
    rig: SerialRig, tmp_path: Path, what: str
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
