"""The cost of recording: CPU time of the whole process for a message, and the loop beside it.

`python tests/benchmarks/recording.py` publishes an Imu on four topics 10,000 times a second
together, for some seconds, and prints the CPU time of a message with and without a recording, and
how many messages are missing in the file.
"""

import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from rosbase import Publisher, RecordOptions, make_logger
from rosbase.clock import SystemClock
from rosbase.messages import Imu, Vector3
from rosbase.testing import virtual_backend
from rosbase_mcap.program_recording import ProgramRecording
from rosbase_mcap.reading import read_summary

RATE_HZ = 10_000
TOPICS = 4
SECONDS = 5
# A batch each 10 ms, as a driver would hand them over.
BATCH = RATE_HZ // 100


def run(path: Path | None, compression: str = "") -> tuple[float, int]:
    """Returns the CPU time of a message, in microseconds, and how many are missing."""
    backend = virtual_backend(SystemClock())
    publishers = [backend.create_publisher(Imu, f"imu_{n}/data", 10) for n in range(TOPICS)]
    recording = None
    if path is not None:
        recording = ProgramRecording(RecordOptions(path, compression=compression))
        recording.begin(backend, make_logger("recording"))
    message = Imu(angular_velocity=Vector3(1.0, 2.0, 3.0))
    before = time.process_time_ns()
    sent = _publish(publishers, message)
    if recording is not None:
        recording.close(None)
    cpu_us = (time.process_time_ns() - before) / 1e3 / sent
    backend.close()
    return cpu_us, 0 if path is None else sent - _count(path)


def _publish(publishers: Sequence[Publisher[Imu]], message: Imu) -> int:
    sent, start_ns = 0, time.monotonic_ns()
    for batch in range(SECONDS * RATE_HZ // BATCH):
        for number in range(BATCH):
            publishers[number % TOPICS].publish(message)
        sent += BATCH
        left_ns = start_ns + (batch + 1) * BATCH * 1_000_000_000 // RATE_HZ - time.monotonic_ns()
        time.sleep(max(0, left_ns) / 1e9)
    return sent


def _count(path: Path) -> int:
    with path.open("rb") as stream:
        summary = read_summary(stream)
    return summary.messages if summary is not None else 0


def main() -> int:
    """Prints the table."""
    print(f"{'recording':12}  {'us/message':>10}  {'missing':>7}")
    bare_us, _ = run(None)
    print(f"{'none':12}  {bare_us:10.2f}  {0:7}")
    for compression in ("", "lz4", "zstd"):
        with tempfile.TemporaryDirectory() as folder:
            cpu_us, missing = run(Path(folder) / "run.mcap", compression)
        print(f"{compression or 'plain':12}  {cpu_us:10.2f}  {missing:7}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
