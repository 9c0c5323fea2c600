"""A robot at 200 Hz with the reader of an IMU, recorded in real time and replayed.

`nox -s hour` records an hour of it, and replays it twenty times.
"""

import os
import re
import subprocess
import time
from pathlib import Path

import pytest

from support.command import ROSBASE, RunningRosbase

ROBOT = Path(__file__).parents[1] / "support" / "long_walk.py"
SEED = "19"
RATE_HZ = 200
SECONDS = int(os.environ.get("ROSBASE_REPLAY_SECONDS", "5"))
REPLAYS = int(os.environ.get("ROSBASE_REPLAY_COUNT", "2"))
LIMIT_S = 60 + 3 * SECONDS


def run(*words: str, **variables: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [ROSBASE, *words],
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
        env={**os.environ, **variables},
    )


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("field") / "field.mcap"
    with RunningRosbase("simulate", "--rate", str(RATE_HZ)) as board:
        board.waits_for("rosbase imu", where=board.out)
        (port,) = re.findall(r"device_path:=(\S+)", "\n".join(board.out.lines))
        device = ("-p", "comm_t:=serial", "-p", f"device_path:={port}")
        done = run("run", "--record", str(path), *device, str(ROBOT), str(SECONDS), SEED)
        assert done.returncode == 0, done.stderr
    return path


def sha256(said: str) -> str:
    (found,) = re.findall(r"^sha256: (\w{64})$", said, re.MULTILINE)
    return str(found)


@pytest.mark.timeout(LIMIT_S * (REPLAYS + 2))
def test_every_replay_is_equal_to_the_recording(recording: Path) -> None:
    digests = set()
    for number in range(REPLAYS):
        begin_s = time.monotonic()
        done = run("replay", str(recording), "--check")
        took_s = time.monotonic() - begin_s
        assert done.returncode == 0, done.stdout + done.stderr
        assert "no difference" in done.stderr
        digests.add(sha256(done.stderr))
        print(f"replay {number}: {took_s:.1f} s, {SECONDS / took_s:.0f} times real time")
    assert len(digests) == 1


@pytest.mark.timeout(LIMIT_S * 2)
def test_a_change_of_the_last_digit_is_found(recording: Path, tmp_path: Path) -> None:
    text = ROBOT.read_text().replace("__file__", repr(str(ROBOT)))
    changed = tmp_path / "changed.py"
    changed.write_text(text.replace("gain * axis", "gain * axis * 1.0000000000000002"))
    done = run("replay", str(recording), str(changed), "--check")
    assert done.returncode == 1, done.stdout + done.stderr
    assert re.search(r"first difference at 00:\d\d\.\d{3}, entry \d+, /cmd_vel", done.stderr)
    assert re.search(r"(linear|angular)\.[xz]: \S+ -> \S+ +\(recorded -> replayed\)", done.stderr)
