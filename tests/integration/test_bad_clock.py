"""The reader as a process on a machine whose date ROS cannot carry."""

import json
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from imu_serial.simulator import PtyDevice
from support.command import ROSBASE, RunningRosbase, summary_of
from support.faketime import FakeDate, needs_faketime
from support.streaming import streaming
from support.waiting import wait_until

pytestmark = needs_faketime


@pytest.fixture
def device() -> Iterator[PtyDevice]:
    """A device that sends fifty samples a second."""
    device = PtyDevice()
    with streaming(device):
        yield device


@contextmanager
def reading(date: FakeDate, device: PtyDevice) -> Iterator[RunningRosbase]:
    """A reader that prints what it publishes, at that date."""
    path = device.parameters["device_path"]
    command = date.command(ROSBASE, "imu", "--topic-echo", "-p", f"device_path:={path}")
    with RunningRosbase(*command[1:], program=command[0]) as reader:
        reader.waits_for("opened")
        yield reader


def stamps(reader: RunningRosbase) -> list[dict[str, Any]]:
    """Those of the samples so far."""
    # The last line may be in the making.
    return [json.loads(line)["header"]["stamp"] for line in reader.out.lines[:-1]]


@pytest.mark.parametrize("date", ["2040-01-01 00:00:00", "1969-06-01 00:00:00"])
def test_samples_go_out_with_a_stamp_of_zero_and_a_signal_ends_it_as_ever(
    tmp_path: Path, device: PtyDevice, date: str
) -> None:
    with reading(FakeDate(tmp_path, date), device) as reader:
        wait_until(lambda: len(reader.out.lines) > 20, "samples")
        reader.waits_for(f"health WARN: stamps are zero: the date of this machine is {date[:11]}")
        assert reader.end(signal.SIGINT) == 0
    assert all(stamp == {"sec": 0, "nanosec": 0} for stamp in stamps(reader))
    assert "Traceback" not in reader.err
    summary = summary_of(reader.err.lines)
    assert summary["clock_unusable"] == summary["published"] > 20
    assert summary["rejected"] == 0
    # No latency was made of them.
    assert "latency_p50_ms" not in summary


def test_stamps_are_right_again_when_somebody_sets_the_clock(
    tmp_path: Path, device: PtyDevice
) -> None:
    date = FakeDate(tmp_path, "1970-01-01 00:00:05")
    with reading(date, device) as reader:
        wait_until(lambda: 5 <= (stamps(reader) or [{"sec": 0}])[-1]["sec"] < 1000, "1970")
        date.set("2040-01-01 00:00:00")
        reader.waits_for("health WARN: stamps are zero: the date of this machine is 2040-01-01")
        wait_until(lambda: stamps(reader)[-1] == {"sec": 0, "nanosec": 0}, "a stamp of zero")
        date.set("2030-01-01 00:00:00")
        reader.waits_for("health OK")
        wait_until(lambda: stamps(reader)[-1]["sec"] >= 1_893_455_000, "a stamp of 2030")
        assert reader.end(signal.SIGINT) == 0
    assert "the system clock was set" in reader.err
    assert "Traceback" not in reader.err
    assert summary_of(reader.err.lines)["rejected"] == 0


def test_the_demo_loses_nothing_in_2040(tmp_path: Path) -> None:
    command = FakeDate(tmp_path, "2040-01-01 00:00:00").command(ROSBASE, "demo", "--duration", "1")
    with RunningRosbase(*command[1:], program=command[0]) as demo:
        assert demo.end() == 0
    summary = summary_of(demo.out.lines)
    assert summary["clock_unusable"] == summary["published"] == summary["sent"] > 0
