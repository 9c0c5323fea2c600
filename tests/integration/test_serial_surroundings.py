"""`rosbase imu` and `rosbase doctor`, and what surrounds a serial port: names, networks, others."""

import signal

import pytest

from support.command import RunningRosbase, run_rosbase
from support.port_holder import hold
from support.samples import GOOD_FRAME
from support.serial_network import Rfc2217Peer, SocketPeer
from support.serial_port import PluggablePort
from support.waiting import wait_until


@pytest.mark.parametrize("kind", [SocketPeer, Rfc2217Peer])
def test_a_port_on_a_network_is_read_and_read_again_after_it_was_away(
    kind: type[SocketPeer],
) -> None:
    peer = kind()
    with RunningRosbase("imu", "-p", f"device_path:={peer.url}", "--topic-echo") as reader:
        reader.waits_for(f"opened {peer.url}")
        for times in (1, 2):
            count = len(reader.out.lines)

            def arrives(count: int = count) -> bool:
                peer.send(GOOD_FRAME)
                return len(reader.out.lines) > count

            wait_until(arrives, "a sample")
            if times == 1:
                peer.unplug()
                reader.waits_for("was lost: the other end has closed the connection")
                peer.replug()
                reader.waits_for("is back")
        assert reader.end(signal.SIGINT) == 0
    assert "plugged in" not in reader.err
    peer.close()


@pytest.mark.parametrize(
    ("path", "says"),
    [
        ("COM4", "COM4 is a name that ports have on Windows"),
        ("socket://127.0.0.1:1", "socket://127.0.0.1:1: nothing listens there"),
    ],
)
def test_what_cannot_be_opened_is_said_by_the_reader_and_the_doctor(path: str, says: str) -> None:
    read = run_rosbase("imu", "-p", f"device_path:={path}", "--duration", "1")
    assert says in read.stderr
    examined = run_rosbase("doctor", "-p", "comm_t:=serial", "-p", f"device_path:={path}")
    assert (examined.returncode, says in examined.stdout) == (1, True)
    for said in (read.stderr, examined.stdout):
        assert "plugged in" not in said
        assert "Traceback" not in said


@pytest.mark.parametrize(
    ("path", "says"),
    [
        ("tcp://192.168.1.20:7000", "write socket://host:port"),
        ("socket://192.168.1.20", "is not host and port"),
    ],
)
def test_an_address_that_cannot_be_is_a_usage_error(path: str, says: str) -> None:
    read = run_rosbase("imu", "-p", f"device_path:={path}", "--duration", "1")
    assert read.returncode == 2
    assert says in read.stderr
    assert len(read.stderr.splitlines()) == 1


def test_another_reader_of_the_port_is_in_the_health_and_the_port_is_not_reopened(
    port: PluggablePort,
) -> None:
    port.plug()
    with (
        hold(port.real_path, "screen", reads="blocking") as other,
        RunningRosbase("imu", "-p", f"device_path:={port.path}") as reader,
    ):
        reader.waits_for("opened")
        said = f"is read by process {other.pid} (screen) too"

        def is_said() -> bool:
            port.write(GOOD_FRAME + b"\r\n")
            return reader.err.count(said) >= 2

        wait_until(is_said, "the other reader, by the transport and in the health")
        assert "health ERROR" in reader.err
        assert "was lost" not in reader.err
        reader.end(signal.SIGINT)


def test_a_port_that_modemmanager_has_at_the_start_is_opened_when_it_lets_go(
    port: PluggablePort,
) -> None:
    port.plug()
    with (
        hold(port.real_path, "ModemManager", how="exclusive") as thief,
        RunningRosbase("imu", "-p", f"device_path:={port.path}", "--topic-echo") as reader,
    ):
        reader.waits_for('ENV{ID_MM_DEVICE_IGNORE}="1"')
        assert thief.stdin is not None
        thief.stdin.write(b"let go\n")
        thief.stdin.flush()
        reader.waits_for("opened")

        def arrives() -> bool:
            port.write(GOOD_FRAME + b"\r\n")
            return bool(reader.out.lines)

        wait_until(arrives, "a sample")
        assert reader.end(signal.SIGINT) == 0
