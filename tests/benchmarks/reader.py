"""The reader beside the same thing written by hand, in one run: CPU per sample, highest rate.

`nox -s bench` runs it and prints a table. Each row is a process of its own that reads the same
lines from a pseudo-terminal. The ratios are what matters: machines are noisy, so the rows take
turns and the cheapest of their turns counts.

- naive: pyserial `readline`, `json.loads`, fill a message, call a function
- careful: the same with chunks of what has arrived instead of `readline`
- rosbase: `ImuReader` on the local backend, with one subscriber on another thread
"""

import json
import resource
import subprocess
import sys
import threading
import time
from collections.abc import Callable

from imu_serial.simulator import PtyDevice
from rosbase.imu.simulator import payload_at
from rosbase.messages import Header, Imu, Quaternion, Time, Vector3

TURNS = 3
PACED_HZ, PACED_S = 1000, 4.0
FLOOD_LINES = 60_000


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


def read_naive(path: str, wanted: int, got: Callable[[Imu], object]) -> None:
    import serial

    with serial.Serial(path, 115_200, timeout=5) as port:
        print("ready", flush=True)
        for _ in range(wanted):
            got(to_message(port.readline()))


def read_careful(path: str, wanted: int, got: Callable[[Imu], object]) -> None:
    import serial

    seen, rest = 0, b""
    with serial.Serial(path, 115_200, timeout=5) as port:
        print("ready", flush=True)
        while seen < wanted:
            *lines, rest = (rest + port.read(max(1, port.in_waiting))).split(b"\n")
            for line in lines:
                got(to_message(line))
            seen += len(lines)


def read_rosbase(path: str, wanted: int, got: Callable[[Imu], object]) -> None:
    from rosbase.contracts.backend import BackendOptions
    from rosbase.imu.reader import ImuReader
    from rosbase.local import LocalBackend

    backend = LocalBackend(BackendOptions("bench", {"device_path": path}))
    reader = ImuReader(backend=backend)
    backend.create_subscription(Imu, "imu/data", got, wanted)
    reader.trigger_configure()
    reader.trigger_activate()
    print("ready", flush=True)
    deadline_ns = time.monotonic_ns() + 60 * 10**9
    backend.spin_until(deadline_ns, lambda: reader.counts.published >= wanted)
    while backend.spin_once(0.0):
        pass
    reader.trigger_shutdown()
    backend.close()


READERS = {"naive": read_naive, "careful": read_careful, "rosbase": read_rosbase}


def child(name: str, path: str, wanted: int) -> None:
    """Reads, and prints what it cost."""
    count = 0

    def got(message: Imu) -> None:
        nonlocal count
        count += 1

    before = resource.getrusage(resource.RUSAGE_SELF)
    READERS[name](path, wanted, got)
    after = resource.getrusage(resource.RUSAGE_SELF)
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(count, cpu_s, flush=True)


def measure(name: str, lines: int, rate_hz: float | None) -> tuple[float, float]:
    """Microseconds of CPU per sample, and samples per second, of one turn."""
    device = PtyDevice()
    path = str(device.parameters["device_path"])
    with subprocess.Popen(
        [sys.executable, __file__, name, path, str(lines)], stdout=subprocess.PIPE, text=True
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
        count, cpu_s = reader.stdout.readline().split()
        took_s = time.monotonic() - start
        writer.join()
    device.close()
    assert int(count) == lines, f"{name} lost {lines - int(count)}"
    return float(cpu_s) / lines * 1e6, lines / took_s


def main() -> None:
    """Prints the table."""
    paced = int(PACED_HZ * PACED_S)
    cpu = {name: float("inf") for name in READERS}
    rate = dict.fromkeys(READERS, 0.0)
    for _ in range(TURNS):
        for name in READERS:
            cpu[name] = min(cpu[name], measure(name, paced, PACED_HZ)[0])
            lines = FLOOD_LINES if name != "naive" else FLOOD_LINES // 20
            rate[name] = max(rate[name], measure(name, lines, None)[1])
    print(f"{'':10}{'us CPU/sample':>16}{'of careful':>12}{'samples/s':>12}{'of careful':>12}")
    for name in READERS:
        print(
            f"{name:10}{cpu[name]:16.1f}{cpu[name] / cpu['careful']:12.2f}"
            f"{rate[name]:12.0f}{rate[name] / rate['careful']:12.2f}"
        )


if __name__ == "__main__":
    if len(sys.argv) == 4:
        child(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    else:
        main()
