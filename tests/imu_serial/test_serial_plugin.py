import subprocess
import sys

from rosbase.imu.settings import reader_parameters
from rosbase.plugins import installed_plugins

LIST = """
import sys
from rosbase.cli import main
main(["plugins"])
assert not {"serial", "termios", "imu_serial.port"} & set(sys.modules), "imported too much"
"""


def test_the_transport_is_found_under_its_name() -> None:
    (record,) = [r for r in installed_plugins().plugins if r.distribution == "imu-serial"]
    assert (record.failure, record.name) == ("", "serial")
    assert installed_plugins().transport("serial").summary == "lines from a serial port"


def test_listing_plugins_imports_no_device_library() -> None:
    shown = subprocess.run(
        [sys.executable, "-c", LIST], capture_output=True, text=True, timeout=30, check=True
    )
    assert "transport: serial" in shown.stdout


def test_the_parameters_have_the_defaults_of_the_first_reader() -> None:
    defaults = {spec.name: spec.default for spec in reader_parameters(installed_plugins())}
    assert defaults["device_path"] == "/dev/ttyUSB0"
    assert defaults["baudrate"] == 115_200
    assert defaults["comm_t"] == "serial"
    assert defaults["wait_for_device"] is False
