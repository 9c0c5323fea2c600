"""The reader beside the same thing written by hand, in one run: CPU per sample, highest rate.

`nox -s bench` runs it and prints a table. Each row is a process of its own that reads the same
lines from a pseudo-terminal. The rows take turns; the medians of the turns count, and of ratios,
those of the turn's own. What a start costs, imports included, is a column of its own: modules are
compiled before, as `pip install` leaves them.

- naive: pyserial `readline`, `json.loads`, fill a message, call a function
- careful: the same with chunks of what has arrived instead of `readline`
- careful, handed over: careful on a thread of its own, and `queue.Queue` to the main thread
- rosbase, nobody listens: `ImuReader` on the local backend, to be compared with careful
- rosbase: the same with a subscriber on the main loop, to be compared with careful, handed over
"""

import json
import os
import queue
import resource
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from benchmarks.rig.turns import ratio, take_turns
from imu_serial.simulator import PtyDevice
from rosbase.imu.simulator import payload_at
from rosbase.messages import Header, Imu, Quaternion, Time, Vector3

TURNS = 9
PACED_HZ, PACED_S = 1000, 4.0
FLOOD_LINES = 60_000


def cpu_s() -> float:
    """CPU seconds of this process so far, all threads, system time included."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


class Meter:
    """Counts samples, and what they cost without start and end."""

    def __init__(self, wanted: int) -> None:
        self.wanted, self.count = wanted, 0

    def ready(self) -> None:
        """The device is open: the writer may begin."""
        self.start_s = cpu_s()
        print("ready", flush=True)

    def got(self, message: Imu) -> None:
        self.count += 1

    def end(self) -> None:
        """All that was wanted is there."""
        self.samples_s = cpu_s() - self.start_s


def to_message(line: bytes) -> Imu:
    """What a hand-written reader does: no checks."""
    data = json.loads(line)
    stamp = Time.from_nanoseconds(time.time_ns())
    return Imu(
        header=Header(stamp, "imu_link"),
        orientation=Quaternion(**data["orientation"]),
        angular_velocity=Vector3(**data["angular_velocity"]),
        linear_acceleration=Vector3(**data["linear_acceleration"]),
    )


def read_naive(path: str, meter: Meter) -> None:
    import serial

    with serial.Serial(path, 115_200, timeout=5) as port:
        meter.ready()
        for _ in range(meter.wanted):
            meter.got(to_message(port.readline()))
        meter.end()


def read_in_chunks(path: str, meter: Meter, got: Callable[[Imu], object]) -> None:
    import serial

    seen, rest = 0, b""
    with serial.Serial(path, 115_200, timeout=5) as port:
        meter.ready()
        while seen < meter.wanted:
            *lines, rest = (rest + port.read(max(1, port.in_waiting))).split(b"\n")
            for line in lines:
                got(to_message(line))
            seen += len(lines)


def read_careful(path: str, meter: Meter) -> None:
    read_in_chunks(path, meter, meter.got)
    meter.end()


def read_handed_over(path: str, meter: Meter) -> None:
    hop: queue.Queue[Imu] = queue.Queue()
    reading = threading.Thread(target=read_in_chunks, args=(path, meter, hop.put))
    reading.start()
    for _ in range(meter.wanted):
        meter.got(hop.get())
    meter.end()
    reading.join()


def read_rosbase(path: str, meter: Meter, *, with_subscriber: bool = True) -> None:
    from rosbase.contracts.backend import BackendOptions
    from rosbase.imu.reader import ImuReader
    from rosbase.local import LocalBackend

    backend = LocalBackend(BackendOptions("bench", {"device_path": path}))
    reader = ImuReader(backend=backend)
    if with_subscriber:
        backend.create_subscription(Imu, "imu/data", meter.got, meter.wanted)
    reader.trigger_configure()
    reader.trigger_activate()
    ended: list[bool] = []

    def look() -> None:
        if reader.counts.published >= meter.wanted:
            ended.append(True)

    backend.create_timer(0.02, look)
    meter.ready()
    backend.spin_until(time.monotonic_ns() + 60 * 10**9, lambda: bool(ended))
    while backend.executor.ready:
        backend.spin_once(0.0)
    meter.end()
    if not with_subscriber:
        meter.count = reader.counts.published
    reader.trigger_shutdown()
    backend.close()


def read_unheard(path: str, meter: Meter) -> None:
    read_rosbase(path, meter, with_subscriber=False)


READERS = {
    "naive": read_naive,
    "careful": read_careful,
    "careful, handed over": read_handed_over,
    "rosbase, nobody listens": read_unheard,
    "rosbase": read_rosbase,
}


def child(name: str, path: str, wanted: int) -> None:
    """Reads, and prints what it cost."""
    began_s, meter = cpu_s(), Meter(wanted)
    READERS[name](path, meter)
    print(meter.count, meter.start_s - began_s, meter.samples_s, flush=True)


def measure(name: str, lines: int, rate_hz: float | None) -> tuple[float, float, float]:
    """CPU milliseconds of a start, microseconds per sample, and samples per second."""
    device = PtyDevice()
    path = str(device.parameters["device_path"])
    with subprocess.Popen(
        [sys.executable, __file__, name, path, str(lines)],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as reader:
        assert reader.stdout is not None
        reader.stdout.readline()
        payloads = [payload_at(n / 1000, Time(1, n)) + b"\r\n" for n in range(1000)]
        start = time.monotonic()

        def write() -> None:
            for number in range(lines):
                if rate_hz is not None:
                    time.sleep(max(0.0, start + number / rate_hz - time.monotonic()))
                device.write(payloads[number % 1000])

        writer = threading.Thread(target=write)
        writer.start()
        count, start_s, samples_s = reader.stdout.readline().split()
        took_s = time.monotonic() - start
        writer.join()
    device.close()
    assert int(count) == lines, f"{name} lost {lines - int(count)}"
    return float(start_s) * 1e3, float(samples_s) / lines * 1e6, lines / took_s


def measure_paced(name: str) -> tuple[float, float]:
    """CPU milliseconds of a start, and microseconds per sample at a rate that all can follow."""
    return measure(name, int(PACED_HZ * PACED_S), PACED_HZ)[:2]


def measure_flood(name: str) -> float:
    """Samples per second when the line never rests."""
    return measure(name, FLOOD_LINES if name != "naive" else FLOOD_LINES // 20, None)[2]


@contextmanager
def compiled_modules() -> Iterator[None]:
    """Lets the rows find their modules compiled, wherever they are installed."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["PYTHONPYCACHEPREFIX"] = folder
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        for name in READERS:
            measure(name, 10, PACED_HZ)
        yield


def main() -> None:
    """Prints the table."""
    with compiled_modules():
        paced = take_turns(measure_paced, READERS, TURNS)
        rate = take_turns(measure_flood, READERS, TURNS // 3)
    cpu = {name: [us for _, us in turns] for name, turns in paced.items()}
    others = ("careful", "careful, handed over")
    print(
        f"{'':26}{'us CPU/sample':>14}{'of careful':>12}{'of handed over':>16}"
        f"{'samples/s':>12}{'of careful':>12}{'ms CPU of start':>17}"
    )
    for name in READERS:
        ratios = [ratio(cpu, name, other) for other in others]
        print(
            f"{name:26}{statistics.median(cpu[name]):14.1f}{ratios[0]:12.2f}{ratios[1]:16.2f}"
            f"{statistics.median(rate[name]):12.0f}{ratio(rate, name, 'careful'):12.2f}"
            f"{statistics.median(ms for ms, _ in paced[name]):17.0f}"
        )


if __name__ == "__main__":
    if len(sys.argv) == 4:
        child(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    else:
        main()
