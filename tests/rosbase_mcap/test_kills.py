"""Recordings of programs that are killed, or whose disk is full or gone: they open all the same.

`nox -s recordings` kills a hundred programs, and reads their files with rclpy too.
"""

import errno
import os
import random
import signal
import subprocess
import sys
from argparse import Namespace
from pathlib import Path
from typing import Any

import pytest

from rosbase import RecordOptions, make_logger
from rosbase.messages import Vector3
from rosbase.roles.recording import RECORD_VARIABLE
from rosbase.testing import virtual_backend
from rosbase_mcap.commands import recover_command
from rosbase_mcap.program_recording import ProgramRecording
from rosbase_mcap.reading import messages
from rosbase_mcap.recovery import is_complete
from support.recording_readers import READERS
from support.waiting import wait_until

RUNS = int(os.environ.get("ROSBASE_RECORDING_KILLS", "10"))

# It says the date of each message before it publishes it, so that a loss can be measured.
PROGRAM = """
import os, sys, time
from rosbase import BaseManager, BaseNode, LifecycleNode
from rosbase.messages import CompressedImage, Vector3


class Talker(BaseNode):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.point = self.create_publisher(Vector3, "point", 10)
        self.image = self.create_publisher(CompressedImage, "image", 10)


class Robot(BaseManager):
    ticks, size = int(sys.argv[1]), int(sys.argv[2])

    def main_loop(self):
        super().main_loop()
        os.write(1, b"%d\\n" % time.time_ns())
        self.node(Talker).point.publish(Vector3(float(self.timestamp)))
        if self.size:
            self.node(Talker).image.publish(CompressedImage(data=bytes(self.size)))
        if self.timestamp == self.ticks:
            self.request_stop()


Robot("robot", {"talker": Talker, "arm": LifecycleNode}).start_main_loop_timer()
"""


def check(path: Path) -> list[tuple[float, int]]:
    """Reads a file in every way that is installed; returns x and date of each point."""
    with path.open("rb") as stream:
        assert is_complete(stream)
    found = []
    for read in READERS:
        points = [(one.x, stamp) for topic, stamp, one in read(path) if topic == "/point"]
        found.append(sorted(points))
    assert all(points == found[0] for points in found)
    return found[0]


@pytest.mark.parametrize("turn", range(RUNS))
def test_a_kill_loses_at_most_the_last_second(tmp_path: Path, turn: int) -> None:
    chance = random.Random(turn)
    options = RecordOptions(
        tmp_path / "run.mcap",
        compression=chance.choice(["", "lz4", "zstd"]),
        split_bytes=chance.choice([0, 0, 30_000]),
    )
    after, size = chance.randrange(600), chance.choice([0, 0, 10_000])
    command = [sys.executable, "-c", PROGRAM, "0", str(size)]
    environment = {**os.environ, RECORD_VARIABLE: options.to_text()}
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        sent = [int(process.stdout.readline()) for _ in range(after)]
        process.send_signal(signal.SIGKILL)
        sent += [int(line) for line in process.stdout if line.endswith(b"\n")]
    points: list[tuple[float, int]] = []
    # The name of a part has its number; the first has none.
    for path in sorted(tmp_path.glob("*.mcap"), key=lambda path: (len(path.name), path.name)):
        # What was killed before the first write is no file of MCAP yet.
        if path.stat().st_size or points:
            recover_command.run(Namespace(file=path, output=None))
            points += check(path)
    assert [x for x, _ in points] == [float(n + 1) for n in range(len(points))]
    if sent:
        last_ns = points[-1][1] if points else sent[0]
        assert sent[-1] - last_ns < 1_000_000_000


def _can_mount() -> bool:
    probe = ["unshare", "-m", "sh", "-c", "mount -t tmpfs tmpfs /mnt"]
    try:
        return subprocess.run(probe, check=False, capture_output=True).returncode == 0
    except OSError:
        return False


@pytest.mark.skipif(not _can_mount(), reason="mounting a file system is not allowed")
@pytest.mark.parametrize(("megabytes", "size"), [(1, 4_000), (20, 100_000)])
def test_a_full_disk_ends_the_recording_and_the_program_goes_on(
    tmp_path: Path, megabytes: int, size: int
) -> None:
    disk, kept = tmp_path / "disk", tmp_path / "kept"
    disk.mkdir()
    kept.mkdir()
    # Only this process and its children see the disk.
    script = (
        f'mount -t tmpfs -o size={megabytes}m tmpfs {disk} && "$@"; status=$?;'
        f" cp {disk}/* {kept}; exit $status"
    )
    ticks = 3 * megabytes * 1_000_000 // size
    program = [sys.executable, "-c", PROGRAM, str(ticks), str(size)]
    done = subprocess.run(
        ["unshare", "-m", "sh", "-c", script, "sh", *program],
        env={**os.environ, RECORD_VARIABLE: str(disk / "run.mcap")},
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.split()) == ticks
    assert done.stderr.count("the recording ends here, the program goes on: ") == 1
    assert "No space left" in done.stderr
    points = check(kept / "run.mcap")
    assert [x for x, _ in points] == [float(n + 1) for n in range(len(points))]
    assert 0 < len(points) < ticks


def test_a_disk_that_is_gone_ends_the_recording_and_the_program_goes_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    class Gone:
        closed = False

        def __getattr__(self, name: str) -> Any:
            raise OSError(errno.EIO, "Input/output error")

    path = tmp_path / "run.mcap"
    backend: Any = virtual_backend()
    recording = ProgramRecording(RecordOptions(path))
    recording.begin(backend, make_logger("test"))
    publisher = backend.create_publisher(Vector3, "point", 10)
    publisher.publish(Vector3(1.0))
    recorder: Any = recording._recorder
    recorder.drain()
    sink: Any = recording._sink
    file, sink._output._file = sink._output._file, Gone()
    publisher.publish(Vector3(2.0))
    wait_until(lambda: recorder.is_broken, "the end of the recording")
    wait_until(lambda: not backend._bus._taps, "the end of the taps")
    publisher.publish(Vector3(3.0))
    backend.close()
    recording.close(None)
    file.close()
    assert caplog.text.count("Input/output error") == 1
    recover_command.run(Namespace(file=path, output=None))
    with path.open("rb") as stream:
        found = [entry.channel.topic for entry in messages(stream)]
    assert found.count("/point") == 1
