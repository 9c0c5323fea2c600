"""How much faster than real time a recorded program is replayed, two replays at a time.

`nox -s bench -- replaying` runs it. It records the quadruped of the examples at 200 Hz with an IMU
on a pseudo-terminal for a minute, and replays it with `rosbase replay --check`.

- alone: one replay; with the start, and without it
- two at a time: seconds of the recording for each second of real time, of all replays together
- by CPU: what two idle cores would give; without the start, as the CPU of a tick

`python tests/benchmarks/replaying.py FILE REPLAYS` replays a recording that there is.
"""

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from attrs import frozen

from imu_serial.simulator import PtyDevice
from rosbase import ImuSimulator
from rosbase_mcap.reading import read_summary

SECONDS, SEED, RATE_HZ, REPLAYS, AT_ONCE = 60, 7, 200, 20, 2
PROGRAM = str(Path(__file__).parents[1] / "support" / "long_walk.py")
ROSBASE = (sys.executable, "-m", "rosbase")


@frozen
class Replay:
    """What one replay took, and what it came to."""

    cpu_s: float
    took_s: float
    status: int
    sha256: str


def record(path: Path) -> None:
    """Records the walk, on a device that sends 200 measurements a second."""
    device = PtyDevice()
    simulator = ImuSimulator(device, rate_hz=RATE_HZ, is_attended=False)
    simulator.start()
    given = [f"{name}:={value}" for name, value in device.parameters.items()]
    parameters = [word for one in ("comm_t:=serial", *given) for word in ("-p", one)]
    program = (PROGRAM, str(SECONDS), str(SEED))
    command = [*ROSBASE, "run", "--record", str(path), *parameters, *program]
    environment = {**os.environ, "PYTHONHASHSEED": "0"}
    try:
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    finally:
        simulator.stop()
        device.close()


def replay(path: Path, *options: str) -> Replay:
    """Replays a recording in processes of its own."""
    command = [*ROSBASE, "replay", "--check", *options, str(path)]
    started_s = time.monotonic()
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said)
        _, status, used = os.wait4(process.pid, 0)
        # So that it is not waited for again.
        process.returncode = os.waitstatus_to_exitcode(status)
        took_s = time.monotonic() - started_s
        said.seek(0)
        digests = [line.split()[1] for line in said if line.startswith("sha256:")]
    return Replay(_cpu_s(used), took_s, process.returncode, "".join(digests))


def _cpu_s(used: resource.struct_rusage) -> float:
    return used.ru_utime + used.ru_stime


def duration_s(path: Path) -> float:
    """Length of a recording."""
    with path.open("rb") as stream:
        summary = read_summary(stream)
    assert summary is not None
    assert summary.start_ns is not None
    assert summary.end_ns is not None
    return (summary.end_ns - summary.start_ns) / 1e9


def print_result(path: Path, count: int) -> bool:
    """Replays as often, prints a table, and returns whether all came to the same."""
    length_s = duration_s(path)
    # The first one writes the bytecode of the modules.
    replay(path, "--to", "0")
    starts = [replay(path, "--to", "0") for _ in range(3)]
    start_s = statistics.median(one.took_s for one in starts)
    start_cpu_s = statistics.median(one.cpu_s for one in starts)
    loops = [loop_s()]
    alone = replay(path)
    started_s = time.monotonic()
    with ThreadPoolExecutor(AT_ONCE) as pool:
        replays = list(pool.map(lambda _: replay(path), range(count)))
    took_s = time.monotonic() - started_s
    loops.append(loop_s())
    cpu_s = statistics.median(one.cpu_s for one in replays) - start_cpu_s
    together_s = took_s - start_s * count / AT_ONCE
    print(f"\nquadruped and IMU at {RATE_HZ} Hz, {length_s:.0f} s\n{'':20}{'times real time':>18}")
    rows = (
        ("alone", length_s / alone.took_s),
        ("  without start", length_s / (alone.took_s - start_s)),
        (f"{AT_ONCE} at a time", count * length_s / took_s),
        ("  without start", count * length_s / together_s),
        ("by CPU", AT_ONCE * length_s / cpu_s),
    )
    for name, times in rows:
        print(f"{name:20}{times:18.0f}")
    print(f"\nCPU {cpu_s:.2f} s, {cpu_s / length_s / RATE_HZ * 1e6:.0f} us a tick; ", end="")
    print(f"start {start_cpu_s:.2f} s")
    print(f"a loop of two million additions: {loops[0]:.2f} s before, {loops[1]:.2f} s after")
    return print_verdict([alone, *replays])


def loop_s() -> float:
    """What a loop of plain Python takes, which tells a slow machine from a slow replay."""
    started_s = time.perf_counter()
    total = 0
    for number in range(2_000_000):
        total += number * number % 7
    return time.perf_counter() - started_s


def print_verdict(replays: Sequence[Replay]) -> bool:
    """Prints whether all replays are equal, and equal to the recording."""
    digests = {one.sha256 for one in replays}
    is_right = len(digests) == 1 and not any(one.status for one in replays)
    print(f"{len(replays)} replays, {len(digests)} SHA-256, ", end="")
    print("no difference" if is_right else "DIFFERENT")
    return is_right


def main() -> int:
    """Prints the table."""
    if len(sys.argv) == 3:
        return not print_result(Path(sys.argv[1]), int(sys.argv[2]))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "walk.mcap")
        record(path)
        return not print_result(path, REPLAYS)


if __name__ == "__main__":
    sys.exit(main())
