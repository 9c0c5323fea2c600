"""The reader under the load of a fast line: nothing is lost, little is used, nothing grows."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import pytest

from support.command import ROSBASE, summary_of
from support.waiting import wait_until

# A 3 Mbaud line carries 300 kB a second (ten bits for each byte).
BYTES_PER_S = 300_000
DURATION_S = 6

# The machine's other work makes a process look slower and more expensive, never cheaper.
ATTEMPTS = 3

# Writes what is due by the clock, again and again: without a pause a few bytes at a time, as a
# UART without a deep buffer hands them over; with one, what a USB adapter brings at once.
WRITER = """
import sys, time
from imu_serial.simulator import PtyDevice
from rosbase.imu.simulator import payload_at
from rosbase.messages import Time

bytes_per_s, duration_s, pause_s = (float(word) for word in sys.argv[1:])
lines = [payload_at(n / 1000, Time(1_700_000_000 + n, n)) + b"\\r\\n" for n in range(1000)]
block = b"".join(lines)
device = PtyDevice()
print(device.parameters["device_path"], flush=True)
sys.stdin.readline()
start, sent, total = time.monotonic(), 0, int(bytes_per_s * duration_s)
while sent < total:
    due = min(total, int((time.monotonic() - start) * bytes_per_s))
    offset = sent % len(block)
    chunk = block[offset : offset + due - sent]
    device.write(chunk)
    sent += len(chunk)
    time.sleep(pause_s)
rest = block[sent % len(block) :].split(b"\\n")[0] + b"\\n"
device.write(rest)
sent += len(rest)
whole, part = divmod(sent, len(block))
print(whole * len(lines) + block[:part].count(b"\\n"), time.monotonic() - start, flush=True)
sys.stdin.readline()
"""


@contextmanager
def process(*command: str) -> Iterator["subprocess.Popen[str]"]:
    """A process that is gone at the end, however the test ends."""
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as started:
        try:
            yield started
            started.wait(20)
        finally:
            if started.poll() is None:
                started.kill()


def ask(started: "subprocess.Popen[str]") -> str:
    """The next line that it prints."""
    assert started.stdout is not None
    return started.stdout.readline().strip()


def tell(started: "subprocess.Popen[str]") -> None:
    """Has it go on."""
    assert started.stdin is not None
    started.stdin.write("\n")
    started.stdin.flush()


def status_of(pid: int) -> tuple[float, int]:
    """CPU seconds and resident kilobytes of a process."""
    stat = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    ticks = int(stat[11]) + int(stat[12])
    rss = next(
        line for line in Path(f"/proc/{pid}/status").read_text().splitlines() if "VmRSS" in line
    )
    return ticks / 100, int(rss.split()[1])


# What a careful programmer writes by hand: no checks, but the main thread gets the samples.
BY_HAND = """
import sys
sys.path.insert(0, sys.argv[2])
from benchmarks.reader import Meter, read_handed_over
read_handed_over(sys.argv[1], Meter(sys.maxsize))
"""
BY_HAND_DURATION_S = 3
TESTS = str(Path(__file__).parents[1])


def writer_for(duration_s: float, pause_s: float) -> tuple[str, ...]:
    """The command that writes for so long."""
    return (sys.executable, "-c", WRITER, str(BYTES_PER_S), str(duration_s), str(pause_s))


class Load(NamedTuple):
    """What a reader did with a flow of data."""

    sent: int
    took_s: float
    core_share: float
    grown_kb: int
    counts: dict[str, float]


def read_a_flow(pause_s: float) -> Load:
    """Has `rosbase imu` read a flow, both in processes of their own."""
    with (
        process(*writer_for(DURATION_S, pause_s)) as writer,
        process(ROSBASE, "imu", "-p", f"device_path:={ask(writer)}") as reader,
    ):
        assert " Hz " in ask(reader)
        cpu_before_s, _ = status_of(reader.pid)
        tell(writer)
        # A second into the flow, everything that is made once has been made.
        shown = [ask(reader) for _ in range(2)]
        _, early_kb = status_of(reader.pid)
        sent, took_s = (float(word) for word in ask(writer).split())
        cpu_after_s, late_kb = status_of(reader.pid)

        def has_all() -> bool:
            shown.append(ask(reader))
            return f"published {int(sent)} " in shown[-1]

        wait_until(has_all, f"{sent} samples")
        reader.terminate()
        assert reader.stdout is not None
        counts = summary_of(reader.stdout.read().splitlines())
        tell(writer)
    share = (cpu_after_s - cpu_before_s) / took_s
    return Load(int(sent), took_s, share, late_kb - early_kb, counts)


def share_by_hand(pause_s: float) -> float:
    """The share of a core that a reader written by hand takes for such a flow."""
    with process(*writer_for(BY_HAND_DURATION_S, pause_s)) as writer:
        with process(sys.executable, "-c", BY_HAND, ask(writer), TESTS) as reader:
            assert ask(reader) == "ready"
            before_s, _ = status_of(reader.pid)
            tell(writer)
            _, took_s = (float(word) for word in ask(writer).split())
            after_s, _ = status_of(reader.pid)
            reader.kill()
        tell(writer)
    return (after_s - before_s) / took_s


@pytest.mark.once
@pytest.mark.timeout(180)
@pytest.mark.parametrize(
    # What the reader costs more is for checks, health and statistics. It rests between two reads.
    ("pause_s", "most_of_by_hand"),
    [(0.0, 1.0), (0.001, 1.6)],
)
def test_a_3_mbaud_line_costs_little_more_than_by_hand_and_loses_nothing(
    pause_s: float, most_of_by_hand: float
) -> None:
    for _ in range(ATTEMPTS):
        load = read_a_flow(pause_s)
        assert load.counts["published"] == load.counts["received"] == load.sent
        assert load.sent > BYTES_PER_S * DURATION_S / 400
        assert (load.counts["rejected"], load.counts["dropped"]) == (0, 0)
        assert load.grown_kb < 500
        by_hand = share_by_hand(pause_s)
        if load.core_share < most_of_by_hand * by_hand and load.took_s < DURATION_S * 1.1:
            return
    pytest.fail(f"the reader used {load.core_share:.3f} of a core, by hand it is {by_hand:.3f}")
