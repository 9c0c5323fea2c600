"""What it costs a program to record itself, beside rclpy with rosbags written by hand.

`nox -s bench` runs it and prints two tables. Each row is a process of its own. The rows take turns;
the medians of the turns count.

An Imu on four topics, 10,000 times a second together:

- alone: a manager that publishes
- recorded, lz4: the same with `record=`, plain and compressed
- rclpy: a program of rclpy that publishes
- rclpy, rosbags: the same, which writes each message with the writer of rosbags
- rclpy, subscriber: a process beside it subscribes, and writes with rosbags

"missing" is what was published and is not in the file.

A manager at 200 Hz that publishes an Imu on four topics in each tick: how far its periods are off,
alone and recorded. One program is recorded every other second, so that whatever else the machine
does falls on both rows.
"""

import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import frozen

from benchmarks.rig.turns import take_turns
from rosbase import BaseHandlers, BaseManager, BaseNode, RecordOptions
from rosbase.messages import Header, Imu, Vector3
from rosbase_mcap.program_recording import ProgramRecording
from rosbase_mcap.reading import messages
from support.ros_domain import own_domain

TOPICS = 4
RATE_HZ, SECONDS, TURNS = 10_000, 4, 5
# A batch each 10 ms, as a driver would hand them over.
BATCH = RATE_HZ // 100
# The windows take five minutes: a 99th percentile of fewer periods is a matter of luck.
LOOP_HZ, WINDOW_S, WINDOWS = 200, 2, 160
# Ticks at the start of a window, in which a recording begins or ends.
LEFT_OUT = 40
BY_HAND = str(Path(__file__).parent / "by_hand" / "recording.py")
ROWS = ("alone", "recorded", "lz4", "rclpy", "rclpy, rosbags", "rclpy, subscriber")


class Talker(BaseNode):
    """Has four topics."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.imus = [self.create_publisher(Imu, f"imu_{n}/data", 10) for n in range(TOPICS)]


class Handlers(BaseHandlers):
    """Publishes in each tick; at the end it prints its CPU, and what `said` returns."""

    def __init__(
        self, manager: Any = None, *, batch: int = 0, ticks: int = 0, **kwargs: Any
    ) -> None:
        super().__init__(manager, **kwargs)
        self.batch, self.ticks = batch, ticks
        self.starts: list[int] = []
        self.imus = manager.node(Talker).imus
        self.before_ns = time.process_time_ns()

    def handle(self) -> None:
        self.starts.append(time.monotonic_ns())
        for number in range(self.batch):
            header = Header(self.manager.backend.clock.now(), "imu_link")
            rates = Vector3(1.0, 2.0, float(number))
            self.imus[number % TOPICS].publish(Imu(header, angular_velocity=rates))
        if len(self.starts) >= self.ticks:
            self.manager.request_stop()


class Alternating(Handlers):
    """Is recorded in every other window; prints the periods of both kinds, and their CPU."""

    def __init__(self, manager: Any = None, *, folder: str = "", **kwargs: Any) -> None:
        super().__init__(manager, batch=TOPICS, ticks=WINDOWS * WINDOW_S * LOOP_HZ, **kwargs)
        self.folder = folder
        self.recording: ProgramRecording | None = None
        self.periods: dict[str, list[int]] = {"alone": [], "recorded": []}
        self.cpu_ns = dict.fromkeys(self.periods, 0)

    def handle(self) -> None:
        window, tick = divmod(len(self.starts), WINDOW_S * LOOP_HZ)
        kind = "recorded" if window % 2 else "alone"
        if tick == 0:
            self.switch(window)
        elif tick == LEFT_OUT:
            self.before_ns = time.process_time_ns()
        super().handle()
        if tick > LEFT_OUT:
            self.periods[kind].append(self.starts[-1] - self.starts[-2])
        if tick == WINDOW_S * LOOP_HZ - 1:
            self.cpu_ns[kind] += time.process_time_ns() - self.before_ns

    def switch(self, window: int) -> None:
        if self.recording is not None:
            self.recording.close(None)
            self.recording = None
        elif window % 2:
            self.recording = ProgramRecording(RecordOptions(f"{self.folder}/{window}.mcap"))
            self.recording.begin(self.manager.backend, self.manager.logger)


def run_loop(folder: str) -> None:
    """The program of the second table."""
    app = BaseManager(
        "talker", {"talker": Talker}, {}, Alternating, node_freq_hz=LOOP_HZ, folder=folder
    )
    app.start_main_loop_timer()
    handlers: Any = app.handlers
    if handlers.recording is not None:
        handlers.recording.close(None)
    print(json.dumps([handlers.periods, handlers.cpu_ns]))


def run(rate_hz: str, batch: str, ticks: str, path: str, compression: str) -> None:
    """A row that is a manager. The end of the recording is a part of its cost."""
    record = RecordOptions(path, compression=compression) if path else None
    app = BaseManager(
        "talker",
        {"talker": Talker},
        {},
        Handlers,
        node_freq_hz=float(rate_hz),
        record=record,
        batch=int(batch),
        ticks=int(ticks),
    )
    handlers: Any = app.handlers
    app.start_main_loop_timer()
    cpu_ns = time.process_time_ns() - handlers.before_ns
    print(cpu_ns, len(handlers.starts) * int(batch))


@frozen
class Turn:
    """What one turn of one row measured."""

    cpu_us: float
    """CPU of all processes for each message."""
    missing: int


def measure(row: str) -> Turn:
    """One turn of a row."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.mcap")
        if row.startswith("rclpy"):
            cpu_ns, sent = _by_hand(row, path)
        else:
            compression = "lz4" if row == "lz4" else ""
            to = "" if row == "alone" else str(path)
            numbers = ("100", str(BATCH), str(SECONDS * 100))
            cpu_ns, sent = map(int, _said(_start(__file__, "run", *numbers, to, compression)))
        files = [path] if path.is_file() else sorted(path.glob("*.mcap"))
        missing = sent - sum(map(_count, files)) if files else 0
    return Turn(cpu_ns / 1e3 / sent, missing)


def _by_hand(row: str, path: Path) -> tuple[int, int]:
    """What a row of rclpy takes, and what it has published."""
    recorder = None
    if row == "rclpy, subscriber":
        recorder = _start(BY_HAND, "record", str(path))
        assert recorder.stdout is not None
        recorder.stdout.readline()
    to = str(path) if row == "rclpy, rosbags" else ""
    cpu_ns, sent = map(int, _said(_start(BY_HAND, "publish", to, str(SECONDS), str(BATCH))))
    if recorder is not None:
        # What is on its way.
        time.sleep(1.0)
        recorder.send_signal(signal.SIGINT)
        cpu_ns += int(_said(recorder)[0])
    return cpu_ns, sent


def _count(path: Path) -> int:
    with path.open("rb") as stream:
        return sum(entry.channel.topic.startswith("/imu_") for entry in messages(stream))


def _start(*command: str) -> "subprocess.Popen[str]":
    return subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, text=True)


def _said(process: "subprocess.Popen[str]") -> list[str]:
    out, _ = process.communicate()
    return out.split()


def print_rows(rows: Mapping[str, Sequence[Turn]]) -> None:
    """Prints medians."""
    print(f"\nImu on {TOPICS} topics, {RATE_HZ} Hz\n{'':20}{'us/message':>12}{'missing':>10}")
    for name, turns in rows.items():
        cpu = statistics.median(turn.cpu_us for turn in turns)
        print(f"{name:20}{cpu:12.1f}{statistics.median(turn.missing for turn in turns):10.0f}")


def print_loop() -> None:
    """Runs the loop, and prints how far its periods are off."""
    with tempfile.TemporaryDirectory() as folder:
        out = _start(__file__, "run_loop", folder).communicate()[0]
    periods, cpu_ns = json.loads(out)
    print(
        f"\nmanager at {LOOP_HZ} Hz with {TOPICS} topics\n{'':20}{'us CPU/tick':>12}"
        f"{'us p50':>8}{'us p90':>8}{'us p99':>8}{'of alone':>10}"
    )
    alone_us = 0.0
    for name, found in periods.items():
        errors = sorted(abs(period - 1_000_000_000 // LOOP_HZ) / 1000 for period in found)
        p50, p90, p99 = (errors[len(errors) * part // 100] for part in (50, 90, 99))
        alone_us = alone_us or p99
        cpu_us = cpu_ns[name] / 1000 / len(found)
        print(f"{name:20}{cpu_us:12.1f}{p50:8.1f}{p90:8.1f}{p99:8.1f}{p99 / alone_us:10.2f}")


def main() -> None:
    """Prints the tables."""
    os.environ |= {
        "ROS_DOMAIN_ID": str(own_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    wanted: Sequence[str] = sys.argv[1:] or ("messages", "loop")
    if "messages" in wanted:
        print_rows(take_turns(measure, ROWS, TURNS))
    if "loop" in wanted:
        print_loop()


if __name__ == "__main__":
    if sys.argv[1:2] == ["run"]:
        run(*sys.argv[2:])
    elif sys.argv[1:2] == ["run_loop"]:
        run_loop(*sys.argv[2:])
    else:
        main()
