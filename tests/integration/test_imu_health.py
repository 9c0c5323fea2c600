"""The health of `rosbase imu` on a real line: by samples, whatever else arrives, at any rate."""

import json
import random
import signal
import time
from collections.abc import Callable

import pytest

from rosbase.imu.rejects import REASONS
from support.command import RunningRosbase, summary_of
from support.samples import GOOD_FRAME
from support.serial_port import PluggablePort
from support.waiting import wait_until

GOOD_LINE = GOOD_FRAME + b"\n"
SKETCH = b'{"accel_x":0.1,"accel_y":0.2,"accel_z":9.8,"gyro_x":0.1,"gyro_y":0.2,"gyro_z":0.3}\n'
TEMPERATURE = b'{"temp":21.5}\n'

# By a name: what arrives and how often, the reason, and a part of what is said.
USELESS: dict[str, tuple[bytes, float, str, str]] = {
    "another message at 4 Hz": (TEMPERATURE, 4.0, "no_imu_data", "is the preset right?"),
    "another message at 9 Hz": (TEMPERATURE, 9.0, "no_imu_data", "is the preset right?"),
    "a letter without an end": (b"A" * 25, 20.0, "unended", "bytes without an end of line"),
    "a heartbeat": (b"heartbeat\n", 2.0, "not_data", REASONS["not_data"]),
    "floats of four bytes": (b"\x00\x80\xf6\x42\xc3\xf5\x1c\x41" * 3, 50.0, "unended", "bytes"),
    "a line held low": (bytes(16), 30.0, "unended", "bytes without an end of line"),
    "blank lines": (b"\r\n", 5.0, "no_frame", "blank lines"),
    "a prompt": (b"\r> ", 3.0, "not_data", REASONS["not_data"]),
}


def reading(port: PluggablePort, *more: str) -> RunningRosbase:
    """A reader on the port."""
    port.plug()
    reader = RunningRosbase("imu", "-p", f"device_path:={port.path}", *more)
    reader.waits_for("opened")
    return reader


def play(port: PluggablePort, data: bytes, rate_hz: float, until: Callable[[], object]) -> float:
    """Writes at a rate until something holds; gives how many seconds that took."""
    begun_s = time.monotonic()
    written = 0

    def writes() -> object:
        nonlocal written
        if time.monotonic() - begun_s >= written / rate_hz:
            port.write(data)
            written += 1
        return until()

    wait_until(writes, "what is to be seen meanwhile")
    return time.monotonic() - begun_s


def for_seconds(seconds: float) -> Callable[[], bool]:
    """Holds when so much time has passed."""
    end_s = time.monotonic() + seconds
    return lambda: time.monotonic() > end_s


@pytest.mark.parametrize(("data", "rate_hz", "reason", "part"), USELESS.values(), ids=USELESS)
def test_what_is_no_sample_is_a_warning_in_time_that_stays_and_is_said_once(
    port: PluggablePort, data: bytes, rate_hz: float, reason: str, part: str
) -> None:
    said = f"health WARN: nothing usable arrives: {reason}: "
    with reading(port, "-p", "preset:=mpu6050") as reader:
        # Twice as long as is promised, for a machine that is busy.
        took_s = play(port, data, rate_hz, lambda: said in reader.err)
        assert took_s < 4.0
        play(port, data, rate_hz, for_seconds(2.0))
        assert reader.end(signal.SIGINT) == 0
    health = [line for line in reader.err.lines if "health " in line]
    assert len(health) <= 2, health
    assert not [line for line in health if "OK" in line]
    assert part in health[-1]
    counts = summary_of(reader.out.lines)
    if reason != "no_frame":
        assert counts[reason] >= 1
    assert counts["published"] == 0
    # The live line, and the summary.
    shown = [line for line in reader.out.lines if line.startswith("WARN nothing usable arrives")]
    assert f"WARN nothing usable arrives: {reason}: " in shown[-1]
    assert reader.out.lines[-1].startswith(f"health WARN nothing usable arrives: {reason}: ")


def test_a_heartbeat_after_good_samples_is_a_warning_and_samples_heal_it(
    port: PluggablePort,
) -> None:
    with reading(port, "-p", "preset:=mpu6050") as reader:
        play(port, SKETCH, 50.0, lambda: "health OK: samples arrive" in reader.err)
        play(port, b"heartbeat\n", 2.0, lambda: "usable arrives: not_data" in reader.err)
        again = reader.err.count("health OK")
        took_s = play(port, SKETCH, 50.0, lambda: reader.err.count("health OK") > again)
        assert took_s < 1.0
        assert reader.end(signal.SIGINT) == 0
    levels = [
        line.split("health ")[1].split(":")[0] for line in reader.err.lines if "health" in line
    ]
    assert levels == ["OK", "WARN", "OK"]
    assert "health" not in reader.out.lines[-1]


def test_a_board_that_goes_silent_in_the_middle_of_a_line_is_silent(port: PluggablePort) -> None:
    with reading(port) as reader:
        play(port, GOOD_LINE, 50.0, lambda: "health OK: samples arrive" in reader.err)
        port.write(GOOD_LINE + GOOD_LINE[:20])
        reader.waits_for("health WARN: no data for 1.")
        reader.waits_for("health ERROR: no data for 5.")
        assert reader.end(signal.SIGINT) == 0
    assert "unended" not in reader.err


def test_a_line_that_is_too_long_is_said_in_the_log_like_any_other(port: PluggablePort) -> None:
    with reading(port, "--topic-echo") as reader:
        # What arrives before the node is active is discarded, be it half of a line.
        play(port, GOOD_LINE, 20.0, lambda: reader.out.lines)
        port.write(b"x" * 70_000 + b"\n" + GOOD_LINE)
        reader.waits_for("overlong (too long for a sample")
        assert reader.end(signal.SIGINT) == 0
    assert json.loads(reader.out.lines[0])["linear_acceleration"]["z"] == 9.80665


def test_random_bytes_at_a_wrong_rate_do_not_flap(port: PluggablePort) -> None:
    with reading(port) as reader:
        play(port, random.Random(4).randbytes(64), 100.0, for_seconds(4.0))
        assert reader.end(signal.SIGINT) == 0
    health = [line for line in reader.err.lines if "health " in line]
    assert 1 <= len(health) <= 3
    assert not [line for line in health if "WARN" not in line]
