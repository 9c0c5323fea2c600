"""S14: a port that another program has, at the start and later: waited for, and who has it said.

The other programs are real processes, some under the names of known ones. Tests run as root too,
whom the kernel lets open what another program has for itself.
"""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from imu_serial.config import SerialConfig
from imu_serial.holders import Process, holder_of, running_takers
from imu_serial.port import Port
from rosbase.contracts.transport import TransportState
from rosbase.errors import DeviceBusyError
from support.port_holder import hold
from support.serial_rig import SerialRig, elapsed, wait_for_state
from support.waiting import wait_until

UDEV = 'ENV{ID_MM_DEVICE_IGNORE}="1"'


@pytest.fixture
def port(rig: SerialRig) -> str:
    """A port that is plugged in, by its real name; whoever it is may open it."""
    rig.port.plug()
    Path(rig.port.real_path).chmod(0o666)
    return rig.port.real_path


def test_a_port_that_modemmanager_probes_for_two_seconds_is_waited_for(
    rig: SerialRig, port: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    with hold(port, "ModemManager", how="exclusive", seconds=2.0) as thief:
        transport = rig.transport()
        assert elapsed(transport.open) < 5.0
        assert transport.is_open
        busy, opened = caplog.messages
        assert f"is in use by process {thief.pid} (ModemManager); it opens new ports" in busy
        assert UDEV in busy
        assert busy.endswith("trying again for 3 s")
        assert opened.startswith("opened ")
    transport.start(rig.keep)
    rig.prove()


@pytest.mark.parametrize(
    ("name", "how", "says"),
    [
        ("ModemManager", "exclusive", UDEV),
        ("brltty", "exclusive", "sudo apt remove brltty"),
        ("gpsd", "locked", 'USBAUTO="false"'),
        ("agetty", "exclusive", "serial-getty@"),
        ("minicom", "locked", "(minicom)"),
        ("a b) c", "exclusive", "(a b) c)"),
        ("\x1b[31mred\u202e", "locked", r"(\x1b[31mred\u202e)"),
    ],
)
def test_who_keeps_a_port_is_named_in_the_error_in_one_line(
    rig: SerialRig, port: str, name: str, how: str, says: str
) -> None:
    with hold(port, name, how=how) as holder:
        with pytest.raises(DeviceBusyError) as caught:
            Port(SerialConfig(port, 115_200))
        text = str(caught.value)
    assert text.startswith(f"{port} is in use by process {holder.pid} (")
    assert says in text
    assert text.isprintable()


def test_a_port_that_stays_busy_is_refused_within_the_limit_of_open(
    rig: SerialRig, port: str
) -> None:
    transport = rig.transport()
    with hold(port, "minicom", how="locked") as holder:

        def refused() -> None:
            with pytest.raises(DeviceBusyError, match=f"process {holder.pid} "):
                transport.open()

        assert 3.0 <= elapsed(refused) < 5.0
        assert str(holder.pid) in transport.health.last_error
    transport.open()


def test_a_port_that_stays_busy_is_waited_for_by_option(
    rig: SerialRig, port: str, caplog: pytest.LogCaptureFixture
) -> None:
    transport = rig.transport(wait=True)
    with hold(port, "minicom", how="exclusive") as holder:
        transport.open()
        transport.start(rig.keep)
        assert transport.health.state is TransportState.RECONNECTING
        assert f"process {holder.pid} (minicom)" in transport.health.last_error
    wait_for_state(transport, TransportState.CONNECTED)
    rig.prove()
    assert len(caplog.messages) == 2, "busy, and waiting for it"


def test_a_port_that_another_program_takes_while_it_is_away_is_taken_back(
    rig: SerialRig, caplog: pytest.LogCaptureFixture
) -> None:
    transport = rig.started()
    rig.port.unplug()
    wait_for_state(transport, TransportState.RECONNECTING)
    # It is faster, because the link to it comes later.
    target = rig.port.path.with_name("target")
    rig.port.path, link = target, rig.port.path
    rig.port.plug()
    with hold(rig.port.real_path, "ModemManager", how="exclusive") as holder:
        link.symlink_to(rig.port.real_path)
        wait_until(lambda: f"process {holder.pid} " in transport.health.last_error, "the holder")
    wait_for_state(transport, TransportState.CONNECTED)
    rig.prove()
    link.unlink()


AS_NOBODY = """
import os, sys
from imu_serial.config import SerialConfig
from imu_serial.port import Port
if os.getuid() == 0:
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
try:
    Port(SerialConfig(sys.argv[1], 115200))
except Exception as error:
    print(type(error).__name__, error)
"""


def as_nobody(port: str) -> str:
    """What a user without privileges is told who opens the port."""
    return subprocess.run(
        [sys.executable, "-c", AS_NOBODY, port], capture_output=True, text=True, check=True
    ).stdout.strip()


def test_who_may_not_see_the_holder_is_told_whom_to_suspect(port: str) -> None:
    with hold(port, "ModemManager", how="exclusive") as holder:
        said = as_nobody(port)
    # Any that runs; a test that does not run as root sees who it is.
    suspect = r"another program; perhaps process \d+ \(ModemManager\); it opens new ports"
    start = re.escape(f"DeviceBusyError {port} is in use by ")
    assert re.match(f"{start}({suspect}|process {holder.pid} )", said)
    assert UDEV in said


def test_who_may_not_see_the_holder_sees_the_owner_of_a_lock(port: str) -> None:
    with hold(port, "minicom", how="locked") as holder:
        said = as_nobody(port)
    assert said == f"DeviceBusyError {port} is in use by process {holder.pid} (minicom)"


def test_a_line_that_a_killed_program_has_left_to_itself_is_free_for_root() -> None:
    """The kernel forgets that with the last who has a port open; of a pseudo-terminal never."""
    near_end, far_end = os.openpty()
    port = os.ttyname(far_end)
    with hold(port, "minicom", how="exclusive") as holder:
        os.close(far_end)
        holder.send_signal(signal.SIGKILL)
        holder.wait()
    if os.getuid() == 0:
        Port(SerialConfig(port, 115_200)).close()
    else:
        # Others are not let in by the kernel.
        with pytest.raises(DeviceBusyError):
            Port(SerialConfig(port, 115_200))
    os.close(near_end)


def test_a_busy_port_is_left_as_it_is(port: str) -> None:
    """One who is refused must not make the port free for all, nor change its settings."""
    with hold(port, "minicom", how="exclusive"):
        for _ in range(2):
            with pytest.raises(DeviceBusyError):
                Port(SerialConfig(port, 9_600))
    free = Port(SerialConfig(port, 115_200))
    for _ in range(2):
        with pytest.raises(DeviceBusyError):
            Port(SerialConfig(port, 9_600))
    assert as_nobody(port).startswith("DeviceBusyError")
    free.close()


def test_known_takers_are_found_while_they_run(port: str) -> None:
    assert "brltty" not in [taker.name for taker in running_takers()]
    with hold("/dev/null", "brltty") as process, hold("/dev/null", "agetty"):
        assert Process(process.pid, "brltty") in list(running_takers())
        assert "agetty" not in [taker.name for taker in running_takers()]


def test_the_last_holder_is_asked_first_and_forgotten_with_its_end(port: str) -> None:
    for name in ("screen", "minicom"):
        with hold(port, name) as process:
            for _ in range(2):
                assert holder_of(port) == Process(process.pid, name)
    assert holder_of(port) is None


SIMULATOR = """
import sys
from imu_serial.simulator import PtyDevice
device = PtyDevice()
print(device.parameters["device_path"], flush=True)
sys.stdin.readline()
device.close()
"""


def test_a_simulated_device_in_another_process_is_no_other_program(rig: SerialRig) -> None:
    """It has both ends of its line open, so that readers may come and go."""
    command = [sys.executable, "-c", SIMULATOR]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as simulator:
        assert simulator.stdout is not None
        path = simulator.stdout.readline().decode().strip()
        assert holder_of(path) is None
        with hold(path, "screen") as other:
            assert holder_of(path) == Process(other.pid, "screen")
        simulator.communicate(b"\n")
