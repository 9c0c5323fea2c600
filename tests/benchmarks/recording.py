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
alone and recorded.
"""

import os
import random
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

from benchmarks.rig.loops import Turn as LoopTurn
from benchmarks.rig.loops import read_turn
from benchmarks.rig.turns import ratio, take_turns
from rosbase import BaseHandlers, BaseManager, BaseNode, RecordOptions
from rosbase.messages import Header, Imu, Vector3
from rosbase_mcap.reading import messages

TOPICS = 4
RATE_HZ, SECONDS, TURNS = 10_000, 4, 5
# A batch each 10 ms, as a driver would hand them over.
BATCH = RATE_HZ // 100
LOOP_HZ, LOOP_SECONDS, LOOP_TURNS = 200, 6, 9
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


def run(rate_hz: str, batch: str, ticks: str, path: str, compression: str, says: str) -> None:
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
    starts = handlers.starts
    print(cpu_ns, *(starts if says == "starts" else [len(starts) * int(batch)]))


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
            cpu_ns, sent = map(int, _said(_start(__file__, "run", *numbers, to, compression, "n")))
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


def measure_loop(row: str) -> LoopTurn:
    """One turn of a loop."""
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder, "run.mcap")) if row == "recorded" else ""
        numbers = (str(LOOP_HZ), str(TOPICS), str(LOOP_HZ * LOOP_SECONDS))
        out = _start(__file__, "run", *numbers, path, "", "starts").communicate()[0]
    return read_turn(out, LOOP_HZ)


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


def print_loops(rows: Mapping[str, Sequence[LoopTurn]]) -> None:
    """Prints medians, and those of the ratios of each turn."""
    print(
        f"\nmanager at {LOOP_HZ} Hz with {TOPICS} topics\n{'':20}{'us CPU/tick':>12}"
        f"{'us p50':>8}{'us p99':>8}{'of alone':>10}{'lost':>6}"
    )
    p99s = {name: [turn.p99_us for turn in turns] for name, turns in rows.items()}
    for name, turns in rows.items():
        cpu, p50, p99, lost = (
            statistics.median(getattr(turn, figure) for turn in turns)
            for figure in ("cpu_us", "p50_us", "p99_us", "lost")
        )
        of_it = ratio(p99s, name, "alone")
        print(f"{name:20}{cpu:12.1f}{p50:8.1f}{p99:8.1f}{of_it:10.2f}{lost:6.0f}")


def main() -> None:
    """Prints the tables."""
    os.environ |= {
        "ROS_DOMAIN_ID": str(random.SystemRandom().randint(1, 100)),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    wanted: Sequence[str] = sys.argv[1:] or ("messages", "loop")
    if "messages" in wanted:
        print_rows(take_turns(measure, ROWS, TURNS))
    if "loop" in wanted:
        print_loops(take_turns(measure_loop, ("alone", "recorded"), LOOP_TURNS))


if __name__ == "__main__":
    if sys.argv[1:2] == ["run"]:
        run(*sys.argv[2:])
    else:
        main()
