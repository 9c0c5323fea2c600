"""The checks of `rosbase imu` as a process, on real lines and a real broker."""

import gzip
import json
import signal
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime, timedelta, timezone
from pathlib import Path
from random import Random
from typing import Any

import pytest

from support.command import RunningRosbase, summary_of
from support.mosquitto import TOPIC, Mosquitto, is_installed
from support.samples import frame, vector
from support.serial_port import PluggablePort
from support.waiting import wait_until

needs_mosquitto = pytest.mark.skipif(not is_installed(), reason="mosquitto is not installed")
SKETCH = b'{"accel_x":0,"accel_y":0.1,"accel_z":9.8,"gyro_x":0,"gyro_y":0,"gyro_z":0.1}'


@contextmanager
def reading(port: PluggablePort, *more: str) -> Iterator[RunningRosbase]:
    """A reader that has opened the port."""
    port.plug()
    with RunningRosbase("imu", "-p", f"device_path:={port.path}", *more) as reader:
        reader.waits_for("opened")
        yield reader


@contextmanager
def subscribed(tmp_path: Path, *more: str) -> Iterator[tuple[Mosquitto, RunningRosbase]]:
    """A broker, and a reader that has subscribed there."""
    broker = Mosquitto(tmp_path)
    try:
        with RunningRosbase(
            "imu", "-p", "comm_t:=mqtt", "-p", f"server_address:={broker.address}",
            "-p", f"mqtt_topic:={TOPIC}", *more,
        ) as reader:  # fmt: skip
            wait_until(lambda: "Sending SUBACK" in broker.log, "the subscription")
            yield broker, reader
    finally:
        broker.stop()


def send_until(send: Callable[[], object], reader: RunningRosbase, part: str) -> None:
    """Sends at 50 Hz until the reader has said that."""
    sent_s = 0.0

    def is_said() -> bool:
        nonlocal sent_s
        if time.monotonic() - sent_s > 0.02:
            sent_s = time.monotonic()
            send()
        return part in reader.err

    wait_until(is_said, repr(part))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b"12:00:01.250 -> " + SKETCH, "JSON behind '12:00:01.250 -> '"),
        (SKETCH.replace(b"9.8", b"nan"), "nan or inf, as C prints them"),
        (SKETCH.replace(b"_x", b"X").replace(b"accel", b"Accel"), "did you mean"),
        (b"0.1,0.2,9.8,0,0,0.1", "6 numbers in a row (CSV)"),
        (b"\xb5\x62\x01\x07\x5c\x00" + bytes([1, 2, 3, 4] * 20), "UBX"),
        (b"\x8f\x13\xe2\x91\xf0\x03\x88", "check the baud rate"),
        (b"MPU6050 Found!", "a device may say so when it starts"),
    ],
)
def test_over_a_serial_line_the_log_names_the_cause(
    port: PluggablePort, line: bytes, said: str
) -> None:
    with reading(port, "-p", "preset:=mpu6050") as reader:
        send_until(lambda: port.write(line + b"\r\n"), reader, said)
        assert reader.end(signal.SIGINT) == 0
    if "baud rate" not in said:
        assert "baud rate" not in reader.err


@needs_mosquitto
@pytest.mark.parametrize(
    ("payload", "said"),
    [
        (gzip.compress(SKETCH, mtime=0), "compressed with gzip; the sender must not compress it"),
        (zlib.compress(SKETCH), "compressed with zlib"),
        (b"\x8f\x13\xe2\x91\xf0\x03\x88", "is it the right topic?"),
        (b"online", "is it the right topic?"),
        (b'{"payload":"{\\"accel_x\\":0}"}', "'payload', a text that holds JSON"),
    ],
)
def test_over_mqtt_the_log_names_the_cause_and_no_baud_rate(
    tmp_path: Path, payload: bytes, said: str
) -> None:
    with subscribed(tmp_path, "-p", "preset:=mpu6050") as (broker, reader):
        broker.publish(payload)
        reader.waits_for(said)
        assert reader.end(signal.SIGINT) == 0
    assert "baud rate" not in reader.err
    assert "plugged in" not in reader.err


def test_lines_that_lost_bytes_between_them_do_not_pass_with_a_checksum(
    port: PluggablePort,
) -> None:
    def signed(x: float) -> bytes:
        content = SKETCH.replace(b'"accel_x":0', f'"accel_x":{x}'.encode())
        return content + f"*{zlib.crc32(content):08X}".encode()

    first, second = signed(0.25), signed(3.5)
    spliced = first[: first.index(b'"accel_y"')] + second[second.index(b'"accel_y"') :]
    options = ("-p", "preset:=mpu6050", "-p", "checksum:=crc32", "--topic-echo")
    with reading(port, *options) as reader:
        send_until(
            lambda: port.write(spliced + b"\r\n"), reader, "bad_checksum (crc32 of the line is "
        )
        port.write(second + b"\r\n")
        reader.waits_for('"x":3.5', where=reader.out)
        assert reader.end(signal.SIGINT) == 0
    assert summary_of(reader.err.lines)["published"] == len(reader.out.lines) == 1


def test_a_sensor_that_hangs_is_warned_of_and_heals(port: PluggablePort) -> None:
    stuck = frame(linear_acceleration=vector(0.0213, -0.0544, 9.8012)) + b"\n"
    with reading(port) as reader:
        send_until(lambda: port.write(stuck), reader, "health WARN: all numbers are the same")
        draw = Random(1)

        def send_live() -> None:
            x, y, z = draw.gauss(0, 0.02), draw.gauss(0, 0.02), draw.gauss(9.81, 0.02)
            port.write(frame(linear_acceleration=vector(x, y, z)) + b"\n")

        send_until(send_live, reader, "health OK")
        assert reader.end(signal.SIGINT) == 0


def test_a_quaternion_in_the_wrong_order_is_warned_of(port: PluggablePort) -> None:
    draw = Random(1)

    def send() -> None:
        x, y, z = draw.gauss(0, 0.02), draw.gauss(0, 0.02), draw.gauss(9.81, 0.02)
        turned = {"x": 1.0, "y": 0.0, "z": 0.0, "w": 0.0}
        changed: dict[str, Any] = {"orientation": turned, "linear_acceleration": vector(x, y, z)}
        port.write(frame(**changed) + b"\n")

    with reading(port) as reader:
        send_until(send, reader, "is mapping.orientation.order wxyz, not xyzw?")
        assert reader.end(signal.SIGINT) == 0


@needs_mosquitto
def test_a_clock_that_is_half_a_day_off_is_warned_of_over_mqtt(tmp_path: Path) -> None:
    paths = ["acc", "gyr", "at"]
    acc, gyr, at = (f"mapping.{name}:=[{path}]" for name, path in zip(
        ("linear_acceleration.paths", "angular_velocity.paths", "time.paths"), paths, strict=True
    ))  # fmt: skip
    options = [
        *("preset:=custom", acc, gyr, at, "time_source:=device", "mapping.time.unit:=s"),
        *("mapping.linear_acceleration.unit:=m/s^2", "mapping.angular_velocity.unit:=rad/s"),
    ]
    given = [word for option in options for word in ("-p", option)]
    with subscribed(tmp_path, *given) as (broker, reader):

        def send() -> None:
            date = datetime.now(timezone.utc) + timedelta(hours=5, minutes=30)
            text = date.isoformat().replace("+00:00", "Z")
            broker.publish(json.dumps({"at": text, "acc": [0, 0, 9.8], "gyr": [0, 0, 0]}).encode())

        said = "health WARN: the device's clock is 5 h 30 min ahead: a time zone?"
        send_until(send, reader, said)
        assert reader.end(signal.SIGINT) == 0
