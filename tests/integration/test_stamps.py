"""Stamps of `rosbase imu` as a process, on real lines, also after it stood still."""

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from support.command import RunningRosbase, summary_of
from support.mosquitto import TOPIC, Mosquitto, is_installed
from support.mqtt import Publisher
from support.paced import Echoed, Paced, Uart, echoed
from support.waiting import wait_until

# On a busy machine the device, too, is late now and then, but not each time.
ATTEMPTS = 4
HZ = 100.0
# A stamp is off by the time that the machine needs to wake up everybody.
MOST_OFF_S = 0.3

Run = tuple[RunningRosbase, Paced]


@contextmanager
def on_a_line(hz: float = HZ, together: int = 1) -> Iterator[Run]:
    """A reader on a line, and a device that sends."""
    line = Uart()
    with RunningRosbase("imu", "-p", f"device_path:={line.path}", "--topic-echo") as reader:
        reader.waits_for("opened")
        device = Paced(line.write, hz, together)
        try:
            yield reader, device
        finally:
            device.end()
            line.close()


@contextmanager
def on_a_broker(folder: Path, hz: float = HZ, together: int = 1) -> Iterator[Run]:
    """The same over a broker."""
    broker = Mosquitto(folder)
    with Publisher(broker.port) as publisher, RunningRosbase(
        "imu", "-p", "comm_t:=mqtt", "-p", f"server_address:={broker.address}",
        "-p", f"mqtt_topic:={TOPIC}", "--topic-echo",
    ) as reader:  # fmt: skip
        reader.waits_for("connected to")

        def send(lines: bytes) -> None:
            for line in lines.splitlines():
                publisher.publish(line, TOPIC, qos=0)

        device = Paced(send, hz, together)
        try:
            yield reader, device
        finally:
            device.end()
            reader.end(signal.SIGINT)
            broker.stop()


def wait_for_more(reader: RunningRosbase, count: int) -> None:
    """Waits for so many more samples."""
    before = len(reader.out.lines)
    wait_until(lambda: len(reader.out.lines) >= before + count, f"{count} more samples")


def stand_still(reader: RunningRosbase, seconds: float) -> None:
    reader.process.send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    reader.process.send_signal(signal.SIGCONT)


def require_rising(samples: list[Echoed]) -> None:
    numbers = [sample.number for sample in samples]
    assert numbers == sorted(set(numbers))
    assert all(after.stamp_ns > before.stamp_ns for before, after in pairwise(samples))


def are_true(samples: list[Echoed], device: Paced) -> bool:
    """Whether each stamp is the time of the sending, but for the machine's own delays."""
    off_s = [(sample.stamp_ns - device.sent_ns[sample.number]) / 1e9 for sample in samples]
    print(f"off by {min(off_s):.3f} to {max(off_s):.3f} s")
    return min(off_s) > -MOST_OFF_S and max(off_s) < MOST_OFF_S


@pytest.mark.parametrize("transport", ["serial", "mqtt"])
def test_a_stall_of_a_fifth_of_a_second_leaves_the_stamps_10_ms_apart(
    tmp_path: Path, transport: str
) -> None:
    if transport == "mqtt" and not is_installed():
        pytest.skip("mosquitto is not installed")
    for _ in range(ATTEMPTS):
        with on_a_line() if transport == "serial" else on_a_broker(tmp_path) as (reader, device):
            wait_for_more(reader, 50)
            stopped_ns = time.time_ns()
            stand_still(reader, 0.2)
            went_on_ns = time.time_ns()
            wait_for_more(reader, 50)
            assert reader.end(signal.SIGINT) == 0
        samples = echoed(reader.out.lines)
        require_rising(samples)
        waited = [s for s in samples if stopped_ns < device.sent_ns[s.number] < went_on_ns]
        gaps_ms = [(after.stamp_ns - before.stamp_ns) / 1e6 for before, after in pairwise(waited)]
        print(gaps_ms)
        are_even = len(gaps_ms) > 15 and min(gaps_ms) > 8.0 and max(gaps_ms) < 12.0
        if are_true(samples, device) and are_even:
            return
    pytest.fail("the stamps were uneven or wrong each time")


def test_two_lines_in_one_write_have_two_stamps() -> None:
    for _ in range(ATTEMPTS):
        with on_a_line(hz=40.0, together=2) as (reader, device):
            wait_for_more(reader, 100)
            assert reader.end(signal.SIGINT) == 0
        samples = echoed(reader.out.lines)
        assert len(samples) >= 100
        require_rising(samples)
        # 25 ms is half of the time between two writes.
        stamps_ms = [sample.stamp_ns / 1e6 for sample in samples[40:]]
        gaps_ms = [after - before for before, after in pairwise(stamps_ms)]
        even = [gap for gap in gaps_ms if 15.0 < gap < 35.0]
        if are_true(samples, device) and len(even) > len(gaps_ms) / 2:
            return
    pytest.fail("the stamps were uneven or wrong each time")


def after_ten_seconds(make: Callable[[], Any]) -> tuple[RunningRosbase, Paced, dict[str, float]]:
    """What became of a reader that stood still for ten seconds."""
    with make() as (reader, device):
        wait_for_more(reader, 100)
        stand_still(reader, 10.0)
        wait_for_more(reader, 50)
        # What waited comes at once; what comes after it is new.
        newest = len(device.sent_ns)
        wait_until(lambda: echoed(reader.out.lines[-1:])[0].number >= newest, "new samples")
        assert reader.end(signal.SIGINT) == 0
    assert "Traceback" not in reader.err
    return reader, device, summary_of(reader.err.lines)


@pytest.mark.once
@pytest.mark.timeout(120)
def test_a_stall_of_ten_seconds_in_which_a_line_overruns_is_counted_and_said() -> None:
    for _ in range(ATTEMPTS):
        reader, device, counts = after_ten_seconds(on_a_line)
        samples = echoed(reader.out.lines)
        require_rising(samples)
        assert reader.err.count("nothing was read for 1") == 1
        # Of a thousand, the line has kept what it has room for.
        assert 20 < counts["late"] < 900
        assert counts["late_frames"] >= counts["late"]
        if are_true(samples, device):
            return
    pytest.fail("the stamps were wrong each time")


@pytest.mark.once
@pytest.mark.timeout(120)
@pytest.mark.skipif(not is_installed(), reason="mosquitto is not installed")
def test_a_stall_of_ten_seconds_over_mqtt_is_counted_and_said(tmp_path: Path) -> None:
    for _ in range(ATTEMPTS):
        reader, device, counts = after_ten_seconds(lambda: on_a_broker(tmp_path))
        samples = echoed(reader.out.lines)
        require_rising(samples)
        assert reader.err.count("nothing was read for 1") == 1
        assert counts["late_frames"] > 500
        # The broker has kept all of them, so all can be dated: if they were sent at an even rate.
        if are_true(samples, device) and "late" not in counts:
            assert len(samples) > 1_000
            return
    pytest.fail("the stamps were wrong or the messages that had waited dropped each time")
