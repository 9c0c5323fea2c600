"""`rosbase imu` over MQTT as a process, on a real broker."""

import json
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest

from support.command import RunningRosbase, run_rosbase, summary_of
from support.mosquitto import TOPIC, Mosquitto, is_installed, set_password
from support.samples import FAULTS, GOOD, GOOD_FRAME, frame
from support.serial_port import PluggablePort
from support.waiting import wait_until

needs_mosquitto = pytest.mark.skipif(not is_installed(), reason="mosquitto is not installed")

CJSON = {"Ax": 0.1, "Ay": 0.2, "Az": 1.0, "Temperature": 20.5, "Gx": 1.0, "Gy": 2.0, "Gz": 3.0}
WORKSHOP = {
    "accX": 0.1,
    "accY": 0.2,
    "accZ": 9.8,
    "gycX": 0.1,
    "gycY": 0.2,
    "gycZ": 0.3,
    "temp": 20,
}
UGV = {"T": 1002, "r": 1.0, "p": 2.0, "ax": 0.1, "ay": 0.2, "az": 9.8, "gx": 0.1, "gy": 0.2,
       "gz": 0.3, "mx": 1.0, "my": 2.0, "mz": 3.0, "temp": 20.0}  # fmt: skip
SKETCH = {"accel_x": 0.1, "accel_y": 0.2, "accel_z": 9.8, "gyro_x": 0.1, "gyro_y": 0.2,
          "gyro_z": 0.3, "temperature": 20.0}  # fmt: skip
SHAPES = {
    "ros": GOOD,
    "waveshare_ugv": UGV,
    "mpu6050": SKETCH,
    "esp32_workshop": WORKSHOP | {"timestamp": "N/A"},
    "esp32_cjson": CJSON,
}


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Mosquitto]:
    broker = Mosquitto(tmp_path)
    yield broker
    broker.stop()


@contextmanager
def reading(broker: Mosquitto, *more: str) -> Iterator[RunningRosbase]:
    """A reader on the broker, that has subscribed."""
    before = broker.log.count("Sending SUBACK")
    with RunningRosbase(
        "imu", "-p", "comm_t:=mqtt", "-p", f"server_address:={broker.address}",
        "-p", f"mqtt_topic:={TOPIC}", "--topic-echo", *more,
    ) as reader:  # fmt: skip
        wait_until(lambda: broker.log.count("Sending SUBACK") > before, "the subscription")
        yield reader


def without_header(line: str) -> object:
    sample = json.loads(line)
    del sample["header"]
    return sample


@needs_mosquitto
def test_each_fault_counts_as_it_does_over_serial_and_the_next_good_sample_comes_through(
    broker: Mosquitto,
) -> None:
    expected: dict[str, int] = {}
    with reading(broker) as reader:
        for number, (line, reason) in enumerate(FAULTS.values(), start=1):
            expected[reason] = expected.get(reason, 0) + 1
            broker.publish(line)
            mark = number + 0.5
            broker.publish(frame(angular_velocity={"x": mark, "y": 0.0, "z": 0.0}))
            reader.waits_for(f'"angular_velocity":{{"x":{mark},', where=reader.out)
        assert reader.end(signal.SIGINT) == 0
    counts = summary_of(reader.err.lines)
    assert {reason: counts[reason] for reason in expected} == expected
    assert counts["published"] == len(reader.out.lines) == len(FAULTS)
    assert "Traceback" not in reader.err


@needs_mosquitto
def test_conditions_on_the_command_line_find_the_sensors_of_a_phone(broker: Mosquitto) -> None:
    options = [
        "-p", "preset:=custom", "-p", "mapping.required:=[linear_acceleration, angular_velocity]",
        "-p", "mapping.linear_acceleration.unit:=m/s^2",
        "-p", "mapping.angular_velocity.unit:=rad/s",
    ]  # fmt: skip
    for quantity, sensor in (("linear_acceleration", "acc"), ("angular_velocity", "gyr")):
        paths = ", ".join(f"payload[name={sensor}].values.{axis}" for axis in "xyz")
        options += ["-p", f"mapping.{quantity}.paths:=[{paths}]"]
    acc = {"name": "acc", "values": {"x": 0.0, "y": 0.1, "z": 9.7}}
    gyr = {"name": "gyr", "values": {"x": 0.1, "y": 0.0, "z": 0.2}}
    with reading(broker, *options) as reader:
        for number, order in enumerate(([acc, gyr], [gyr, acc], [gyr], [acc, acc, gyr])):
            broker.publish(json.dumps({"messageId": number, "payload": order}).encode())
        wait_until(lambda: len(reader.out.lines) == 2, "two samples")
        broker.publish(json.dumps({"payload": [acc, gyr]}).encode())
        wait_until(lambda: len(reader.out.lines) == 3, "the sample after those that are refused")
        assert reader.end(signal.SIGINT) == 0
    for line in reader.out.lines:
        sample = json.loads(line)
        assert sample["linear_acceleration"] == acc["values"]
        assert sample["angular_velocity"] == gyr["values"]
    counts = summary_of(reader.err.lines)
    assert (counts["missing_group"], counts["surplus"]) == (1, 1)


@needs_mosquitto
@pytest.mark.parametrize("preset", SHAPES)
def test_each_payload_shape_gives_the_samples_that_it_gives_over_serial(
    broker: Mosquitto, tmp_path: Path, preset: str
) -> None:
    payload = json.dumps(SHAPES[preset]).encode()
    port = PluggablePort(tmp_path)
    port.plug()
    with (
        RunningRosbase(
            "imu", "-p", f"device_path:={port.path}", "-p", f"preset:={preset}", "--topic-echo"
        ) as serial,
        reading(broker, "-p", f"preset:={preset}") as reader,
    ):

        def is_reading() -> bool:
            port.write(payload + b"\n")
            return bool(serial.out.lines)

        wait_until(is_reading, "the first sample over serial")
        broker.publish(payload)
        # P10: spread over many lines it is a payload like any other.
        broker.publish(json.dumps(SHAPES[preset], indent=2).encode())
        per_payload = 2 if preset == "waveshare_ugv" else 1
        wait_until(lambda: len(reader.out.lines) >= 2 * per_payload, "both samples")
        assert {str(without_header(line)) for line in reader.out.lines} == {
            str(without_header(line)) for line in serial.out.lines
        }
        assert reader.end(signal.SIGINT) == serial.end(signal.SIGINT) == 0
    port.unplug()


@needs_mosquitto
def test_an_interrupt_ends_it_in_two_seconds_with_the_broker_and_without(
    broker: Mosquitto,
) -> None:
    for is_there in (True, False):
        with reading(broker) as reader:
            if not is_there:
                broker.kill()
                reader.waits_for("trying again")
            begun_s = time.monotonic()
            assert reader.end(signal.SIGINT) == 0
            assert time.monotonic() - begun_s < 2.0
        assert "Traceback" not in reader.err


@needs_mosquitto
def test_a_password_is_seen_nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    set_password(tmp_path / "passwords", "imu", "right-secret")
    broker = Mosquitto(
        tmp_path, more=f"allow_anonymous false\npassword_file {tmp_path / 'passwords'}"
    )
    for password in ("right-secret", "wrong-secret"):
        monkeypatch.setenv("ROSBASE_MQTT_PASSWORD", password)
        with RunningRosbase(
            "imu", "-p", "comm_t:=mqtt", "-p", f"server_address:={broker.address}",
            "-p", "username:=imu", "-p", "wait_for_broker:=true",
        ) as reader:  # fmt: skip
            reader.waits_for(
                "connected to" if password == "right-secret" else "refuses the connection"
            )
            line = Path(f"/proc/{reader.process.pid}/cmdline").read_bytes()
            assert reader.end(signal.SIGINT) == 0
        assert password.encode() not in line
        assert password not in reader.out
        assert password not in reader.err
    broker.stop()


def farewells(broker: Mosquitto) -> list[int]:
    """How often the broker has seen a reader unsubscribe, and disconnect."""
    said = "Received UNSUBSCRIBE from the-reader", "Received DISCONNECT from the-reader"
    return [broker.log.count(line) for line in said]


def farewells_are(broker: Mosquitto, wanted: list[int]) -> bool:
    return farewells(broker) == wanted


@needs_mosquitto
def test_deactivating_unsubscribes_and_disconnects_and_activating_again_works(
    broker: Mosquitto,
) -> None:
    from rosbase.contracts.backend import BackendOptions
    from rosbase.imu.reader import ImuReader
    from rosbase.local import LocalBackend
    from rosbase.messages import Imu

    parameters = {"comm_t": "mqtt", "server_address": broker.address, "client_id": "the-reader"}
    backend = LocalBackend(BackendOptions("mqtt_test", parameters))
    reader = ImuReader(backend=backend)
    arrived: list[Imu] = []
    backend.create_subscription(Imu, "imu/data", arrived.append, 10)
    reader.trigger_configure()
    for _ in range(3):
        arrived.clear()
        before = farewells(broker)
        reader.trigger_activate()
        broker.publish(GOOD_FRAME)
        wait_until(lambda: backend.spin_once(0.01) and arrived, "the sample")
        reader.trigger_deactivate()
        after = [number + 1 for number in before]
        wait_until(partial(farewells_are, broker, after), "the farewell")
    reader.trigger_shutdown()
    backend.close()


def marked(mark: float) -> bytes:
    """A good sample that can be told from others."""
    return frame(angular_velocity={"x": mark, "y": 0.0, "z": 0.0})


def marks(reader: RunningRosbase) -> list[float]:
    """Those of the samples that were published."""
    return [json.loads(line)["angular_velocity"]["x"] for line in reader.out.lines]


@needs_mosquitto
def test_under_a_wildcard_all_samples_of_the_first_device_are_published_until_it_falls_silent(
    broker: Mosquitto,
) -> None:
    with reading(broker, "-p", "mqtt_topic:=lab/#", "-p", "stale_timeout:=2") as reader:
        broker.publish(b'{"hello":"bench 3"}', topic="lab/hello")
        for number in range(10):
            broker.publish(marked(1.0 + number), topic="lab/imu")
            broker.publish(marked(-1.0 - number), topic="lab/imu2")
        reader.waits_for('"x":10.0,', where=reader.out)
        assert marks(reader) == [1.0 + number for number in range(10)]
        reader.waits_for("reading lab/imu")

        def takes_over() -> bool:
            broker.publish(marked(-59.0), topic="lab/imu2")
            return -59.0 in marks(reader)

        wait_until(takes_over, "the other device's samples")
        broker.publish(marked(59.0), topic="lab/imu")
        broker.publish(marked(-60.0), topic="lab/imu2")
        reader.waits_for('"x":-60.0,', where=reader.out)
        assert 59.0 not in marks(reader)
        assert reader.err.count("no sample from lab/imu for") == 1
        assert reader.err.count("reading lab/imu2") == 1
        assert reader.end(signal.SIGINT) == 0
    counts = summary_of(reader.err.lines)
    assert counts["no_imu_data"] == 1
    assert counts["other_topic"] >= 10


def test_the_demo_over_mqtt_publishes_every_sample() -> None:
    done = run_rosbase("demo", "--transport", "mqtt", "--duration", "5", "--no-unplug")
    assert done.returncode == 0, done.stderr
    counts = summary_of(done.stdout.splitlines())
    assert counts["published"] >= 490
    assert counts["sent"] == counts["received"] == counts["published"]
    assert counts["lost"] == 0


def test_the_plug_of_the_demo_over_mqtt_is_its_broker() -> None:
    done = run_rosbase("demo", "--transport", "mqtt", "--duration", "4")
    assert done.returncode == 0, done.stderr
    counts = summary_of(done.stdout.splitlines())
    assert counts["sent"] == counts["published"] > 150
    assert (counts["lost"], counts["reconnects"]) == (0, 1)
    assert "although it was unplugged for" in done.stdout


@pytest.mark.parametrize(
    ("given", "complaint"),
    [
        ("server_address:=http://x", "server_address must be one of tcp://"),
        ("server_address:=tcp://me:hush@x", "server_address must not contain a user or a password"),
        ("mqtt_topic:=a+/b", "+ stands for a whole level"),
        ("status_topic:=esp32/imu", "status_topic matches mqtt_topic"),
        ("password_file:=secret", "password_file needs username"),
    ],
)
def test_what_cannot_be_an_address_or_a_topic_is_one_line_and_status_2(
    given: str, complaint: str
) -> None:
    done = run_rosbase("imu", "-p", "comm_t:=mqtt", "-p", given)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert complaint in done.stderr
    assert "hush" not in done.stderr
