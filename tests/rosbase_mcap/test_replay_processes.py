"""`rosbase run --record` and `rosbase replay` from the command line, as users run them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.plugins import TRANSPORT_PLUGIN, install_plugin

PROGRAM = """
import sys
from rosbase import BaseManager, BaseNode
from rosbase.messages import Vector3

GAIN = 1.0

class Talker(BaseNode):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.declare_parameter("speed", 1.5)
        self.point = self.create_publisher(Vector3, "point", 10)
        self.create_timer(0.01, self.talk)
        # Which one is first depends on the hash seed.
        self.logger.info(f"the first is {next(iter({'a', 'b', 'c', 'd', 'e'}))}")

    def talk(self):
        speed = self.get_parameter("speed").value
        now_s = self.get_clock().monotonic_ns() / 1e9
        self.point.publish(Vector3(speed * GAIN, now_s, float(len(sys.argv))))

class Robot(BaseManager):
    def update_timestamp(self):
        super().update_timestamp()
        if self.timestamp == 50:
            self.request_stop()

if __name__ == "__main__":
    Robot("robot", {"talker": Talker}, node_freq_hz=100).start_main_loop_timer()
"""


def rosbase(folder: Path, *words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONHASHSEED"}
    environment |= variables
    return subprocess.run(
        [sys.executable, "-m", "rosbase", *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=50,
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a program and a recording of it."""
    (tmp_path / "robot.py").write_text(PROGRAM)
    words = ("-p", "talker.speed:=2.5", "robot.py", "one", "two")
    done = rosbase(tmp_path, "run", "--record", "run.mcap", *words)
    assert done.returncode == 0, done.stderr
    return tmp_path


@pytest.fixture
def with_lan(tmp_path: Path) -> dict[str, str]:
    """The environment in which a transport `lan` is installed; there is a program too."""
    (tmp_path / "robot.py").write_text(PROGRAM)
    packages = tmp_path / "packages"
    packages.mkdir()
    install_plugin(packages, "imu-lan", "lan", TRANSPORT_PLUGIN.format(name="lan"))
    return {"PYTHONPATH": str(packages)}


def test_a_replay_has_parameters_arguments_and_hash_seed_of_the_recording(folder: Path) -> None:
    done = rosbase(folder, "replay", "run.mcap", "robot.py", "--check")
    assert (done.returncode, done.stdout) == (0, "")
    assert "no difference: " in done.stderr
    # Also without a name, because the file has it.
    again = rosbase(folder, "replay", "run.mcap", "--check")
    assert again.stderr.splitlines()[-2:] == done.stderr.splitlines()[-2:]
    assert done.stderr.splitlines()[-1].startswith("sha256: ")


def test_a_transport_that_was_installed_and_is_not_any_more_is_named(
    tmp_path: Path, with_lan: dict[str, str]
) -> None:
    record = ("run", "--record", "run.mcap", "robot.py")
    assert rosbase(tmp_path, *record, **with_lan).returncode == 0
    named = "the transport lan is not installed"
    assert named in rosbase(tmp_path, "replay", "run.mcap", "--check").stderr
    assert named not in rosbase(tmp_path, "replay", "run.mcap", "--as-fast", **with_lan).stderr


def test_plugins_that_were_blocked_are_blocked_in_the_replay(
    tmp_path: Path, with_lan: dict[str, str]
) -> None:
    record = ("run", "--record", "run.mcap", "robot.py")
    assert rosbase(tmp_path, *record, ROSBASE_BLOCK_PLUGINS="imu-lan", **with_lan).returncode == 0
    done = rosbase(tmp_path, "replay", "run.mcap", "--check", **with_lan)
    assert done.returncode == 0
    assert "transport" not in done.stderr


def test_a_changed_program_is_named_and_its_difference_is_shown(folder: Path) -> None:
    (folder / "robot.py").write_text(PROGRAM.replace("GAIN = 1.0", "GAIN = 1.000000001"))
    done = rosbase(folder, "replay", "run.mcap", "robot.py", "--check")
    assert done.returncode == 1
    assert "robot.py has changed" in done.stderr
    assert ", /point\n" in done.stderr
    assert "x: 2.5 -> 2.5000000025   (recorded -> replayed)" in done.stderr
    # Without --check, the program counts.
    assert rosbase(folder, "replay", "run.mcap", "robot.py", "--as-fast").returncode == 0


@pytest.mark.parametrize(
    "failure", ["1 / 0", "raise BackendError('no way')"], ids=["of Python", "of rosbase"]
)
def test_an_error_that_ended_the_program_ends_it_again_and_all_is_compared(
    failure: str, tmp_path: Path
) -> None:
    failing = PROGRAM.replace("self.request_stop()", failure)
    (tmp_path / "robot.py").write_text(f"from rosbase import BackendError\n{failing}")
    first = rosbase(tmp_path, "run", "--record", "run.mcap", "robot.py")
    error = first.stderr.splitlines()[-1]
    done = rosbase(tmp_path, "replay", "run.mcap", "--check")
    assert (first.returncode, done.returncode) == (1, 1)
    assert done.stderr.splitlines()[-3] == error
    assert "no difference: " in done.stderr


@pytest.mark.parametrize(
    ("end", "status"), [("KeyboardInterrupt", 130), ("BaseException('weird')", 1)]
)
def test_an_end_by_no_exception_has_a_verdict_too(end: str, status: int, tmp_path: Path) -> None:
    ending = PROGRAM.replace("self.request_stop()", f"raise {end}")
    (tmp_path / "robot.py").write_text(ending)
    first = rosbase(tmp_path, "run", "--record", "run.mcap", "robot.py")
    done = rosbase(tmp_path, "replay", "run.mcap", "--check")
    assert done.returncode == status
    assert first.stderr.splitlines()[-1] in done.stderr
    assert "no difference: " in done.stderr


def test_the_log_is_shown_from_a_time_on(folder: Path) -> None:
    def shown(*words: str) -> bool:
        done = rosbase(folder, "replay", "run.mcap", "--as-fast", *words)
        assert done.returncode == 0, done.stderr
        return "the first is" in done.stderr

    assert shown()
    assert not shown("--from", "0.3s")


def test_a_replay_up_to_a_time_ends_there(folder: Path) -> None:
    done = rosbase(folder, "replay", "run.mcap", "--check", "--to", "0.2s")
    assert done.returncode == 0, done.stderr
    assert "no difference: " in done.stderr


def test_a_program_without_a_manager_is_named(folder: Path) -> None:
    (folder / "other.py").write_text("print('hello')\n")
    done = rosbase(folder, "replay", "run.mcap", "other.py")
    assert (done.returncode, done.stdout) == (2, "hello\n")
    assert "other.py has no manager" in done.stderr


def test_a_program_that_is_not_there_is_one_line(folder: Path) -> None:
    done = rosbase(folder, "replay", "run.mcap", "nowhere.py")
    assert done.returncode == 2
    assert "nowhere.py: no such file" in done.stderr
