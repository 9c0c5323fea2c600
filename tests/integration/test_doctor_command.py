"""`rosbase doctor` as a process, with everything installed."""

import signal

from support.command import RunningRosbase, run_rosbase
from support.mqtt import ScriptedBroker, says_nothing
from support.serial_port import PluggablePort
from support.waiting import wait_until


def test_everything_that_is_installed_has_its_say() -> None:
    done = run_rosbase("doctor")
    assert done.stderr == ""
    checks = {line.split()[1] for line in done.stdout.splitlines() if not line.startswith(" ")}
    assert checks >= {"python:", "plugins:", "serial:", "mqtt:"}


def test_a_reader_at_work_is_seen_and_not_disturbed(port: PluggablePort) -> None:
    port.plug()
    with RunningRosbase("imu", "-p", f"device_path:={port.path}", "--topic-echo") as reader:
        reader.waits_for("opened")
        done = run_rosbase("doctor", "-p", f"device_path:={port.path}")
        assert done.returncode == 1
        assert f"fail  serial: {port.path} is in use by process" in done.stdout
        assert reader.process.poll() is None
        assert reader.end(signal.SIGINT) == 0
        assert "reconnects 0" in reader.err


def test_ctrl_c_ends_it_without_a_word() -> None:
    with ScriptedBroker(says_nothing) as broker:
        address = f"server_address:={broker.address}"
        with RunningRosbase("doctor", "-p", address) as doctor:
            wait_until(lambda: broker.peers, "the broker to be asked")
            assert doctor.end(signal.SIGINT) == -signal.SIGINT
            assert doctor.err.lines == []
