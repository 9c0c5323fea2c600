"""The reader on ROS 2 beside the same thing written by hand, from a line to a subscriber.

`nox -s bench` runs it and prints a table. Device, reader and subscriber are three processes;
the subscriber is plain rclpy and the same for all. The rows take turns, and the medians of the
turns count; of ratios, those of the turn's own.

- naive: pyserial `readline`, `json.loads`, fill an `Imu`, publish, under `rclpy.spin`
- careful: the same with chunks of what has arrived instead of `readline`
- rosbase: `rosbase imu --backend ros2`
"""

import os
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from attrs import frozen

from imu_serial.simulator import PtyDevice
from support.ros_domain import own_domain

BY_HAND = Path(__file__).with_name("by_hand")
TURNS = 5
PACED_S = 4.0
SLOW_HZ, FAST_HZ = 100, 1000
# Of the naive reader as many as it reads in about as long.
FLOOD_LINES = {"naive": 2_000, "careful": 40_000, "rosbase": 40_000}
WARM_UP = -1
PATIENCE_S = 60.0

COMMANDS = {
    "naive": [sys.executable, str(BY_HAND / "reader_node.py"), "naive"],
    "careful": [sys.executable, str(BY_HAND / "reader_node.py"), "careful"],
    "rosbase": [str(Path(sys.executable).with_name("rosbase")), "imu", "--backend", "ros2"],
}


@frozen
class Turn:
    """What one turn of one row measured."""

    cpu_us: float
    """CPU of the reader, for each sample; all threads, the system's part included."""
    p50_ms: float
    """From the writing of a line to the subscriber's callback."""
    p99_ms: float
    rate_hz: float
    """Samples that arrived in each second, from the first to the last."""
    lost: int


def line_of(number: int) -> bytes:
    """A payload of the usual length that says which one it is, in plausible thousandths."""
    return (
        '{"header":{"stamp":{"sec":1700000000,"nanosec":123456789},"frame_id":"imu_link"},'
        '"orientation":{"x":0.0,"y":0.0,"z":0.38268343,"w":0.92387953},'
        f'"angular_velocity":{{"x":{number / 1000:.3f},"y":-0.020000,"z":0.300000}},'
        '"linear_acceleration":{"x":0.100000,"y":-0.200000,"z":9.806650}}\r\n'
    ).encode()


class Subscriber:
    """The process that notes what arrives."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(BY_HAND / "subscriber.py")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def count(self) -> int:
        """How many samples have arrived, those of the warm-up too."""
        return int(self._ask("count"))

    def arrivals(self) -> dict[int, int]:
        """When each sample arrived, by its number. It ends the process."""
        assert self._process.stdout is not None
        found: dict[int, int] = {}
        line = self._ask("end")
        while line != "end\n":
            number, arrival_ns = line.split()
            found[round(float(number) * 1000)] = int(arrival_ns)
            line = self._process.stdout.readline()
        self._process.wait(PATIENCE_S)
        found.pop(WARM_UP, None)
        return found

    def close(self) -> None:
        """Ends it, whatever it does."""
        self._process.kill()
        self._process.communicate()

    def _ask(self, command: str) -> str:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{command}\n")
        self._process.stdin.flush()
        return self._process.stdout.readline()


@contextmanager
def reading(name: str, path: str) -> Iterator[int]:
    """Runs the reader of that row; gives its process id."""
    path_argument = ["-p", f"device_path:={path}"] if name == "rosbase" else [path]
    reader = subprocess.Popen(
        [*COMMANDS[name], *path_argument], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield reader.pid
    finally:
        reader.terminate()
        try:
            reader.wait(PATIENCE_S)
        finally:
            reader.kill()


def cpu_ns(pid: int) -> int:
    """CPU that a process has used so far: the clock that clock_getcpuclockid(3) gives."""
    return time.clock_gettime_ns(~pid << 3 | 2)


def warm_up(device: PtyDevice, subscriber: Subscriber) -> int:
    """Sends until samples arrive; gives how many lines have been sent."""
    sent, deadline_s = 0, time.monotonic() + PATIENCE_S
    while subscriber.count() < 10:
        assert time.monotonic() < deadline_s, "nothing arrives"
        device.write(line_of(WARM_UP))
        sent += 1
        time.sleep(0.02)
    return sent


def measure(name: str, lines: int, rate_hz: float | None) -> Turn:
    """One turn: so many samples at a rate, or as fast as the line takes them."""
    with ExitStack() as stack:
        device = PtyDevice()
        stack.callback(device.close)
        subscriber = Subscriber()
        stack.callback(subscriber.close)
        pid = stack.enter_context(reading(name, str(device.parameters["device_path"])))
        warm_up(device, subscriber)
        time.sleep(0.5)
        before, cpu_before = subscriber.count(), cpu_ns(pid)
        sent_ns: list[int] = []
        writer = threading.Thread(target=write, args=(device, lines, rate_hz, sent_ns))
        writer.start()
        writer.join()
        await_all(subscriber, before + lines)
        cpu = cpu_ns(pid) - cpu_before
        return evaluate(subscriber.arrivals(), sent_ns, cpu)


def write(device: PtyDevice, lines: int, rate_hz: float | None, sent_ns: list[int]) -> None:
    """What the device does."""
    payloads = [line_of(number) for number in range(lines)]
    start_s = time.monotonic()
    for number, payload in enumerate(payloads):
        if rate_hz is not None:
            time.sleep(max(0.0, start_s + number / rate_hz - time.monotonic()))
        sent_ns.append(time.monotonic_ns())
        device.write(payload)


def await_all(subscriber: Subscriber, count: int) -> None:
    """Waits until all have arrived, or none has for two seconds."""
    seen, since_s = subscriber.count(), time.monotonic()
    while seen < count and time.monotonic() - since_s < 2.0:
        time.sleep(0.1)
        now = subscriber.count()
        if now != seen:
            seen, since_s = now, time.monotonic()


def evaluate(arrivals: Mapping[int, int], sent_ns: Sequence[int], cpu: int) -> Turn:
    """The figures of a turn."""
    late = sorted(
        (arrivals[number] - sent) / 1e6 for number, sent in enumerate(sent_ns) if number in arrivals
    )
    took_s = (max(arrivals.values()) - min(arrivals.values())) / 1e9
    return Turn(
        cpu_us=cpu / 1e3 / len(sent_ns),
        p50_ms=late[len(late) // 2],
        p99_ms=late[len(late) * 99 // 100],
        rate_hz=(len(arrivals) - 1) / took_s,
        lost=len(sent_ns) - len(arrivals),
    )


def of_row(turns: Mapping[str, Sequence[Turn]], name: str, other: str, figure: str) -> float:
    """The median of the turns' ratios to another row."""
    return statistics.median(
        float(getattr(mine, figure) / getattr(theirs, figure))
        for mine, theirs in zip(turns[name], turns[other], strict=True)
    )


def show(title: str, turns: Mapping[str, Sequence[Turn]], figures: Mapping[str, str]) -> None:
    """Prints a table."""
    print(f"\n{title}")
    heads = "".join(f"{head:>16}{'of naive':>10}{'of careful':>12}" for head in figures.values())
    print(f"{'':10}{heads}{'p99 ms':>10}{'lost':>7}")
    for name in turns:
        cells = ""
        for figure in figures:
            median = statistics.median(getattr(turn, figure) for turn in turns[name])
            ratios = [of_row(turns, name, other, figure) for other in ("naive", "careful")]
            cells += f"{median:16.2f}{ratios[0]:10.3f}{ratios[1]:12.3f}"
        p99 = statistics.median(turn.p99_ms for turn in turns[name])
        lost = sum(turn.lost for turn in turns[name])
        print(f"{name:10}{cells}{p99:10.2f}{lost:7}")


def main() -> None:
    """Prints the tables."""
    os.environ |= {
        "ROS_DOMAIN_ID": str(own_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }
    turns = int(sys.argv[1]) if len(sys.argv) > 1 else TURNS
    for rate_hz in (SLOW_HZ, FAST_HZ):
        lines = int(rate_hz * PACED_S)
        found = {name: [measure(name, lines, rate_hz) for _ in range(turns)] for name in COMMANDS}
        show(f"{rate_hz} Hz", found, {"cpu_us": "us CPU/sample", "p50_ms": "p50 ms"})
    found = {
        name: [measure(name, FLOOD_LINES[name], None) for _ in range(turns)] for name in COMMANDS
    }
    show("as fast as it goes", found, {"rate_hz": "samples/s", "cpu_us": "us CPU/sample"})


if __name__ == "__main__":
    main()
