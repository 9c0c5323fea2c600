"""The reader on ROS 2: the command as a process, its line, and listeners in other processes."""

import itertools
import json
import os
import signal
import statistics
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from imu_mqtt.simulator import BrokeredDevice
from imu_serial.simulator import PtyDevice
from rosbase.contracts.transport import SimulatedDevice
from rosbase.imu.simulator import payload_at
from rosbase.messages import Time
from support.command import RunningRosbase, run_rosbase, summary_of
from support.listening import WARM_UP_S, Listener, listening
from support.plugins import install_plugin
from support.ros import Client
from support.stopwatch import Stopwatch
from support.streaming import streaming
from support.waiting import wait_until


@pytest.fixture
def device() -> Iterator[PtyDevice]:
    device = PtyDevice()
    yield device
    device.close()


@contextmanager
def reading(device: PtyDevice, *arguments: str) -> Iterator[RunningRosbase]:
    """The reader on that line, with the stamps of the device."""
    with RunningRosbase(
        "imu", "--backend", "ros2", *arguments,
        "-p", f"device_path:={device.parameters['device_path']}", "-p", "time_source:=device",
    ) as reader:  # fmt: skip
        yield reader


_warm_ups = itertools.count()


def warm_up() -> bytes:
    """A sample to begin with; each is dated after the last, for the reader drops repeats."""
    return payload_at(0.0, Time(WARM_UP_S, next(_warm_ups)))


@contextmanager
def heard(device: SimulatedDevice, topic: str = "/imu/data") -> Iterator[Listener]:
    """A listener that has begun to hear the device, by way of a reader."""
    with listening(topic) as listener:

        def hears() -> bool:
            device.send(warm_up())
            return bool(listener.out.lines)

        wait_until(hears, "the first sample")
        yield listener


def send(device: SimulatedDevice, rate_hz: float, count: int) -> list[dict[str, Any]]:
    """Sends so many samples, and gives what a listener should hear."""
    sent = []
    start_s = time.monotonic()
    for number in range(count):
        time.sleep(max(0.0, start_s + number / rate_hz - time.monotonic()))
        payload = payload_at(number / rate_hz, Time.from_nanoseconds(time.time_ns()))
        device.send(payload)
        sent.append(json.loads(payload))
    return sent


def as_sent(message: dict[str, Any]) -> dict[str, Any]:
    """A message that was heard, in the shape of the payload."""
    quantities = {
        name: dict(zip("xyzw", message[name], strict=False))
        for name in ("orientation", "angular_velocity", "linear_acceleration")
    }
    sec, nanosec = message["stamp"]
    stamp = {"sec": sec, "nanosec": nanosec}
    return {"header": {"stamp": stamp, "frame_id": message["frame_id"]}, **quantities}


def test_every_sample_that_comes_over_mqtt_arrives_too() -> None:
    device = BrokeredDevice()
    try:
        parameters = {"comm_t": "mqtt", "time_source": "device", **device.parameters}
        given = [f"-p{name}:={value}" for name, value in parameters.items()]
        with (
            RunningRosbase("imu", "--backend", "ros2", *given) as reader,
            heard(device) as listener,
        ):
            sent = send(device, 100, 100)
            wait_until(lambda: len(listener.heard) >= 100, "100 samples")
            assert [as_sent(message) for message in listener.heard] == sent
            assert end(reader, signal.SIGINT) == 0
    finally:
        device.close()


@pytest.mark.parametrize(("rate_hz", "count"), [(100, 200), (1000, 3000)])
def test_every_sample_arrives_as_it_was_sent(device: PtyDevice, rate_hz: int, count: int) -> None:
    with reading(device) as reader, heard(device) as listener:
        sent = send(device, rate_hz, count)
        wait_until(lambda: len(listener.heard) >= count, f"{count} samples")
        assert [as_sent(message) for message in listener.heard] == sent
        assert reader.end(signal.SIGINT) == 0
    assert summary_of(reader.out.lines)["rejected"] == 0


@pytest.fixture
def client(context: Any) -> Iterator[Client]:
    client = Client(context, "lifecycle_manager")
    yield client
    client.destroy()


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_active_ends_it_at_once_and_the_last_message_is_delivered(
    device: PtyDevice, client: Client, signum: int
) -> None:
    with reading(device) as reader, listening() as listener:
        client.await_services()
        wait_until(lambda: client.state() == "active", "the reader to be active")
        with streaming(device, period_s=0.001, sec=WARM_UP_S + 1):
            wait_until(lambda: len(listener.out.lines) > 100, "a stream")
            assert end(reader, signum) == 0
        published = summary_of(reader.out.lines)["published"]
        wait_until(lambda: listener.heard[-1]["stamp"][1] == published - 1, "the last message")
    numbers = [message["stamp"][1] for message in listener.heard]
    assert numbers == list(range(numbers[0], int(published)))


def end(reader: RunningRosbase, signum: int) -> int:
    """The status with which it ended, if it did so as it should."""
    with Stopwatch() as watch:
        status = reader.end(signum)
        assert watch.took_s < 2.0
    assert "Traceback" not in reader.err, reader.err.lines
    return status


SLOW_TRANSPORT = """
import time
from rosbase.plugins import TransportPlugin, hookimpl
from rosbase.contracts.transport import Transport, TransportHealth

class Slow(Transport):
    is_open = False
    health = TransportHealth()

    def __init__(self, values, context):
        self.logger = context.logger

    def open(self):
        if not self.is_open:
            # First, for the signal may interrupt the rest.
            self.is_open = True
            self.logger.info("opening")
            time.sleep(0.25)

    def start(self, on_frame): pass
    def stop(self): pass

    def close(self):
        if self.is_open:
            self.logger.info("closing")
            time.sleep(0.25)
            self.is_open = False
            self.logger.info("closed")

@hookimpl
def rosbase_transports():
    yield TransportPlugin("slow", "takes its time", Slow)
"""


@contextmanager
def reading_slowly(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RunningRosbase]:
    """A reader whose device takes a quarter of a second to open, and to close."""
    install_plugin(folder, "slow", "slow", SLOW_TRANSPORT)
    path = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    monkeypatch.setenv("PYTHONPATH", path)
    with RunningRosbase("imu", "--backend", "ros2", "-p", "comm_t:=slow") as reader:
        yield reader


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_during_configure_ends_it_soon_with_the_device_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, signum: int
) -> None:
    with reading_slowly(tmp_path, monkeypatch) as reader:
        reader.waits_for("opening")
        assert end(reader, signum) == 0
        assert reader.err.lines[-1].endswith("closed")


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_during_shutdown_ends_it_soon_with_the_device_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, client: Client, signum: int
) -> None:
    with reading_slowly(tmp_path, monkeypatch) as reader:
        client.await_services()
        wait_until(lambda: client.state() == "active", "the reader to be active")
        answer = client.start_change(label="shutdown")
        reader.waits_for("closing")
        assert end(reader, signum) == 0
        assert reader.err.lines[-1].endswith("closed")
        assert client.finish(answer).success


def test_arguments_of_ros_are_heeded(device: PtyDevice, context: Any) -> None:
    path = device.parameters["device_path"]
    client = Client(context, "imu_driver")
    try:
        with RunningRosbase(
            "imu", "--backend", "ros2", "--managed", "--ros-args", "-r", "__node:=imu_driver",
            "-r", "imu/data:=/front/imu", "-p", f"device_path:={path}", "-p", "frame_id:=front",
        ) as reader:  # fmt: skip
            client.await_services()
            assert client.state() == "unconfigured"
            assert client.change(label="configure")
            assert client.change(label="activate")
            with heard(device, "/front/imu") as listener:
                assert json.loads(listener.out.lines[0])["frame_id"] == "front"
            assert end(reader, signal.SIGINT) == 0
        # Managed by others, it shows nothing but its log.
        assert reader.out.lines == []
    finally:
        client.destroy()


def test_what_ros_args_say_wins_over_the_defaults_of_the_command(
    device: PtyDevice, client: Client
) -> None:
    path = device.parameters["device_path"]
    with RunningRosbase(
        "imu", "--backend", "ros2",
        "--ros-args", "-p", f"device_path:={path}", "-p", "autostart:=configure",
    ) as reader:  # fmt: skip
        client.await_services()
        wait_until(lambda: client.state() == "inactive", "the reader to be inactive")
        assert end(reader, signal.SIGINT) == 0


def test_arguments_of_ros_without_ros_are_an_error_not_a_silence() -> None:
    done = run_rosbase("imu", "--ros-args", "-p", "frame_id:=front")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert (
        "--ros-args are for the backend ros2, but this is local: add --backend ros2" in done.stderr
    )


def test_the_reader_alone_subscribes_to_nothing_of_its_own(
    device: PtyDevice, client: Client
) -> None:
    with reading(device) as reader:
        client.await_services()
        wait_until(lambda: client.state() == "active", "the reader to be active")
        wait_until(lambda: client.node.count_publishers("/imu/data") == 1, "the publisher")
        assert client.node.count_subscribers("/imu/data") == 0
        assert end(reader, signal.SIGINT) == 0


def test_diagnostics_are_published_once_a_second_under_the_name_of_the_node(
    device: PtyDevice, client: Client
) -> None:
    heard: list[DiagnosticArray] = []
    client.node.create_subscription(DiagnosticArray, "/diagnostics", heard.append, 10)
    with reading(
        device, "--ros-args", "-r", "__node:=imu_driver", "-r", "__ns:=/front", "--"
    ) as reader:

        def speaks() -> bool:
            client.executor.spin_once(timeout_sec=0.01)
            return len(heard) >= 4

        wait_until(speaks, "diagnostics")
        assert end(reader, signal.SIGINT) == 0
    stamps = [message.header.stamp.sec + message.header.stamp.nanosec / 1e9 for message in heard]
    # The first waits for the main loop to begin, and another one may be late.
    periods = [later - earlier for earlier, later in itertools.pairwise(stamps)]
    assert statistics.median(periods) == pytest.approx(1.0, abs=0.3)
    (status,) = heard[-1].status
    assert status.name == "front/imu_driver: IMU"
    assert status.hardware_id == device.parameters["device_path"]
    assert status.level in (DiagnosticStatus.WARN, DiagnosticStatus.ERROR), "there is no data"
    assert "no data" in status.message


def test_samples_are_echoed_over_ros(device: PtyDevice) -> None:
    with reading(device, "--topic-echo") as reader:

        def echoes() -> bool:
            device.send(warm_up())
            return any('"linear_acceleration"' in line for line in reader.out.lines)

        wait_until(echoes, "a sample")
        assert end(reader, signal.SIGINT) == 0


def test_the_demo_loses_nothing_on_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")
    done = run_rosbase("demo", "--duration", "2", "--no-unplug")
    summary = summary_of(done.stdout.splitlines())
    assert done.returncode == 0, done.stderr
    assert summary["published"] == summary["sent"] >= 190
    assert summary["lost"] == summary["dropped"] == 0
