"""Of which ports the speed is known."""

from pathlib import Path

import pytest

from imu_serial.config import SerialConfig
from imu_serial.port import Port
from imu_serial.simulator import PtyDevice
from imu_serial.uart import bytes_per_s


def test_the_speed_of_a_uart_is_known_also_through_a_link(tmp_path: Path) -> None:
    ttys = tmp_path / "tty"
    for name in ("ttyAMA0", "ttyUSB0", "ttyACM0"):
        (ttys / name).mkdir(parents=True)
    (ttys / "ttyAMA0" / "uartclk").write_text("48000000\n")
    (tmp_path / "imu").symlink_to("/dev/ttyAMA0")
    assert bytes_per_s("/dev/ttyAMA0", 115_200, str(ttys)) == 11_520
    assert bytes_per_s(str(tmp_path / "imu"), 921_600, str(ttys)) == 92_160
    for other in ("/dev/ttyUSB0", "/dev/ttyACM0", "/dev/pts/3", "/dev/not-there"):
        assert bytes_per_s(other, 115_200, str(ttys)) is None


@pytest.mark.skipif(
    not Path("/sys/class/tty/ttyS0/uartclk").exists(), reason="this machine has no ttyS0"
)
def test_the_kernel_says_so_of_its_uarts() -> None:
    assert bytes_per_s("/dev/ttyS0", 115_200) == 11_520


def test_the_speed_of_a_pseudo_terminal_means_nothing() -> None:
    line = PtyDevice()
    port = Port(SerialConfig(str(line.parameters["device_path"]), 115_200))
    assert port.bytes_per_s is None
    port.close()
    line.close()
