"""Names that are no port here are said to be what they are, with the ports that there are."""

import os
import re
from pathlib import Path

import pytest

from imu_serial import refusals
from imu_serial.config import SerialConfig
from imu_serial.port import Port
from rosbase.errors import DeviceNotFoundError, NotADeviceError, TransportError
from support.port_holder import hold
from support.serial_rig import SerialRig


@pytest.fixture(autouse=True)
def ports(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The ports that this machine is said to have."""
    ports = ["/dev/ttyACM0", "/dev/ttyUSB3"]
    monkeypatch.setattr(refusals, "port_names", lambda: ports)
    return ports


def refusal(path: str) -> TransportError:
    with pytest.raises(TransportError) as caught:
        Port(SerialConfig(path, 115_200))
    assert str(caught.value).isprintable()
    return caught.value


@pytest.mark.parametrize("name", ["COM4", "com12", "COM3:", r"\\.\COM10", r"\\?\COM5"])
def test_a_name_of_windows_is_called_one(name: str) -> None:
    error = refusal(name)
    assert isinstance(error, NotADeviceError)
    assert str(error) == (
        f"{name} is a name that ports have on Windows; here there are /dev/ttyACM0, /dev/ttyUSB3"
    )


def test_a_name_of_windows_is_not_waited_for(rig: SerialRig) -> None:
    with pytest.raises(NotADeviceError, match="on Windows"):
        rig.transport(path="COM4", wait=True).open()


def test_where_there_is_no_port_that_is_said(ports: list[str]) -> None:
    ports.clear()
    assert str(refusal("COM4")).endswith("; this machine has no serial port")


@pytest.mark.parametrize("name", ["/dev/cu.usbserial-1420", "/dev/tty.usbmodem14101"])
def test_a_name_of_macos_is_called_one(name: str) -> None:
    assert str(refusal(name)).startswith(f"{name} is a name that ports have on macOS; here there")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("ptmx", "ptmx is not a path; write /dev/ptmx"),
        ("ttyUSB77", "ttyUSB77 is not a path; here there are /dev/ttyACM0, /dev/ttyUSB3"),
        ("1a86:7523", "1a86:7523 is not a port; over a network it is socket://1a86:7523"),
        ("192.168.1.20:7000", "over a network it is socket://192.168.1.20:7000"),
        ("CP2102 USB to UART", "CP2102 USB to UART is not a path; here there are"),
    ],
)
def test_what_is_no_path_is_said_with_what_to_write(name: str, says: str) -> None:
    error = refusal(name)
    assert isinstance(error, NotADeviceError)
    assert says in str(error)


@pytest.mark.parametrize("separator", [":", ",", "@"])
def test_a_rate_behind_the_path_is_said_to_go_elsewhere(rig: SerialRig, separator: str) -> None:
    rig.port.plug()
    path = rig.port.real_path
    assert str(refusal(f"{path}{separator}57600")) == (
        f"{path}{separator}57600 is not there, but {path} is; the rate goes into baudrate:=57600"
    )


def test_a_file_of_such_a_name_that_is_there_is_opened(
    rig: SerialRig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig.port.plug()
    monkeypatch.chdir(tmp_path)
    os.symlink(rig.port.real_path, "COM4")
    Port(SerialConfig("COM4", 115_200)).close()


def test_an_absent_adapter_is_put_down_to_brltty_where_that_runs() -> None:
    path = "/dev/serial/by-id/usb-1a86_USB_Serial-if00-port0"
    plain = refusal(path)
    assert isinstance(plain, DeviceNotFoundError)
    assert str(plain) == f"{path} is not there; is the device plugged in?"
    with hold("/dev/null", "brltty") as process:
        error = refusal(path)
        assert isinstance(error, DeviceNotFoundError)
        assert f"{plain} process {process.pid} (brltty) is running; it takes USB adapters" in str(
            error
        )
        assert "brltty" not in str(refusal("/dev/ttyS77"))


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("", "''"),
        ("a\0b", r"a\x00b"),
        ("/dev/\ud800", r"/dev/\ud800"),
        ("/dev/tty\n", r"/dev/tty\n"),
        ("COM4\x1b[2J", r"COM4\x1b[2J"),
    ],
)
def test_a_name_that_no_file_can_have_or_that_breaks_a_line_is_shown_escaped(
    name: str, shown: str
) -> None:
    assert str(refusal(name)).startswith(f"{shown} ")


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("~/imu", "has a ~ or a $, which only a shell replaces"),
        ("$HOME/imu", "has a ~ or a $, which only a shell replaces"),
        ("/dev/ttyUSB*", "is a pattern, not the name of a port"),
        ("/dev/ttyACM[0-9]", "is a pattern, not the name of a port"),
        ("/dev/ptmx", "makes pseudo-terminals; it is not a serial port"),
    ],
)
def test_a_name_that_no_port_can_have_is_refused_with_the_reason(name: str, why: str) -> None:
    with pytest.raises(NotADeviceError, match=re.escape(why)):
        Port(SerialConfig(name, 115_200))
