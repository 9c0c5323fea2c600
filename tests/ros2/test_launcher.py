"""Programs that the launcher starts on ROS 2."""

import signal
from pathlib import Path

import pytest

from support.launching import up

ROBOT = """
from rosbase import BaseHandlers, BaseManager, LifecycleNode

class Drive(LifecycleNode):
    autostart = "activate"

if __name__ == "__main__":
    manager = BaseManager("robot", {"drive": Drive}, handlers_class=BaseHandlers, node_freq_hz=20)
    print(type(manager.backend).__module__, flush=True)
    manager.start_main_loop_timer()
"""
FILE = """
[[nodes]]
name = "robot"
command = "rosbase run robot.py"
backend = "ros2"
[[nodes]]
name = "driver"
command = "exec sleep TOKEN"
after = { robot = "lifecycle active" }
"""


def test_a_program_waits_for_the_lifecycle_nodes_of_another_on_ros(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setenv("ROSBASE_CONTROL_FOLDER", str(tmp_path / "rosbase"))
    (tmp_path / "robot.py").write_text(ROBOT)
    with up(tmp_path, FILE) as (launcher, token):
        token.wait_for_sleepers(1)
        assert launcher.end(signal.SIGINT) == 0
    assert "robot | rosbase_ros2.backend" in launcher.said
