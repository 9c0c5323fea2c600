"""Recordings of processes that are killed, or run out of space, and open all the same."""

import random
import signal
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import pytest

from rosbase_mcap.reading import messages
from rosbase_mcap.recovery import is_complete, mend

# It prints the time of each message before it is recorded, so that a loss can be measured.
PROGRAM = """
import resource, signal, sys, time
from pathlib import Path
from rosbase import RecordOptions, make_logger
from rosbase.messages import Vector3
from rosbase.testing import virtual_backend
from rosbase.clock import SystemClock
from rosbase_mcap.program_recording import ProgramRecording

path, limit = Path(sys.argv[1]), int(sys.argv[2])
if limit:
    # As on a full disk, but for anybody: a write that goes beyond is an OSError.
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
backend = virtual_backend(SystemClock())
publisher = backend.create_publisher(Vector3, "point", 10)
recording = ProgramRecording(RecordOptions(path))
recording.begin(backend, make_logger("test"))
print("ready", flush=True)
number = 0
end = time.monotonic() + (3.0 if limit else 60.0)
while time.monotonic() < end:
    publisher.publish(Vector3(float(number)))
    number += 1
    print(time.time_ns(), flush=True)
    time.sleep(0.001)
recording.close(None)
backend.close()
"""


def run_killed(path: Path, after: int) -> list[int]:
    """Runs the program until it has published so often; returns the dates of its messages."""
    command = [sys.executable, "-c", PROGRAM, str(path), "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        sent = [int(process.stdout.readline()) for _ in range(after)]
        process.send_signal(signal.SIGKILL)
        return sent


@pytest.mark.parametrize("turn", range(5))
def test_a_kill_loses_at_most_the_last_second(tmp_path: Path, turn: int) -> None:
    path = tmp_path / "run.mcap"
    sent = run_killed(path, random.Random(turn).randrange(100, 2500))
    pieces: list[bytes] = []
    with path.open("rb") as stream:
        outcome = mend(stream, pieces.append)
    mended = b"".join(pieces)
    assert is_complete(BytesIO(mended))
    assert not outcome.damaged_chunks
    found = [entry.message.log_ns for entry in messages(BytesIO(mended))]
    last_ns = found[-1] if found else sent[0]
    assert sent[-1] - last_ns < 1_000_000_000


def test_a_limit_of_the_disk_ends_the_recording_and_the_program_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    command = [sys.executable, "-c", PROGRAM, str(path), "60000"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=50, check=False)
    assert done.returncode == 0, done.stderr
    assert (done.stdout + done.stderr).count("the recording ends here") == 1
    assert path.stat().st_size <= 60_000
    with path.open("rb") as stream:
        assert is_complete(stream)
        assert list(messages(stream))
