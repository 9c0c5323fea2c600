"""Programs that wait for each other's control sockets, and commands that drive a launcher."""

import signal
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rosbase.cli.operate.programs import show_processes
from rosbase.control import connect
from rosbase.errors import ControlError
from rosbase.launcher.description import Condition
from rosbase.launcher.ready_programs import is_ready
from support.launching import up
from support.waiting import wait_until

ACTIVE, HANDSHAKE = Condition("lifecycle active"), Condition("handshake")


@pytest.fixture
def sockets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of a test's own for control sockets."""
    folder = tmp_path / "run"
    folder.mkdir(0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    monkeypatch.setenv("ROSBASE_CONTROL_FOLDER", str(folder / "rosbase"))
    return folder / "rosbase"


ROBOT = """
import os
from rosbase import BaseHandlers, BaseManager, CallbackReturn, LifecycleNode

class Drive(LifecycleNode):
    autostart = "activate"

    def on_activate(self, previous_state):
        while not os.path.exists("activate"):
            pass
        print("active", flush=True)
        return super().on_activate(previous_state)

if __name__ == "__main__":
    manager = BaseManager("robot", {"drive": Drive}, handlers_class=BaseHandlers, node_freq_hz=20)
    manager.add_handshake_rule("a file", lambda: os.path.exists("shake"))
    manager.start_main_loop_timer()
"""
WAITING = """
[[nodes]]
name = "robot"
command = "rosbase run robot.py"
[[nodes]]
name = "shaken"
command = "exec sleep TOKEN"
after = { robot = "handshake" }
[[nodes]]
name = "driver"
command = "exec sleep TOKEN"
after = { robot = "lifecycle active" }
"""


def test_programs_start_when_another_has_passed_its_handshake_and_is_active(
    tmp_path: Path, sockets: Path
) -> None:
    (tmp_path / "robot.py").write_text(ROBOT)
    with up(tmp_path, WAITING) as (launcher, token):
        wait_until(lambda: _phases() == ["handshake"], "the handshake")
        assert not token.sleepers()
        (tmp_path / "shake").touch()
        token.wait_for_sleepers(1)
        launcher.waits_for("shaken * starting")
        assert "driver * starting" not in launcher.said
        (tmp_path / "activate").touch()
        token.wait_for_sleepers(2)
        assert launcher.end(signal.SIGINT) == 0
    assert launcher.said.index("robot | active") < launcher.said.index("driver * starting")
    assert not list(sockets.iterdir())


def _phases() -> list[str]:
    return [
        program["phase"]
        for process in connect().processes()
        for program in process["programs"]
        if program["kind"] == "manager"
    ]


SLEEPERS = """
[env]
session_name = "demo"
[[nodes]]
name = "a"
command = "exec sleep TOKEN"
required = true
restart = "always"
[[nodes]]
name = "b"
command = "exec sleep TOKEN"
[[nodes]]
name = "off"
command = "exec sleep TOKEN"
autostart = false
[[nodes]]
name = "waits"
command = "exec sleep TOKEN"
after = { b = "exit 0" }
"""


def launched() -> Mapping[str, Any]:
    return {one["name"]: one for one in connect().launched()}


def test_other_commands_see_stop_and_restart_what_a_launcher_has_started(
    tmp_path: Path, sockets: Path
) -> None:
    with up(tmp_path, SLEEPERS) as (launcher, token):
        before = token.wait_for_sleepers(2)

        def has_all() -> bool:
            pids = {one["pid"] for one in launched().values()}
            return len(launched()) == 4 and set(before) <= pids

        wait_until(has_all, "the launcher")
        shown = launched()
        assert [shown[name]["state"] for name in ("a", "b", "off", "waits")] == [
            *("running", "running", "disabled", "waiting")
        ]
        assert {shown["a"]["pid"], shown["b"]["pid"]} == set(before)
        assert [shown["a"]["required"], shown["b"]["required"]] == [True, False]
        connect().stop("a")
        assert launched()["a"]["state"] == "stopped"
        assert len(token.sleepers()) == 1
        connect().restart("a")
        connect().restart("b")
        connect().restart("off")
        after = token.wait_for_sleepers(3)
        assert not set(before) & set(after)
        assert [launched()[name]["restarts"] for name in ("a", "b", "off")] == [1, 1, 0]
        with pytest.raises(ControlError, match="nobody"):
            connect().restart("nobody")
        connect().stop("/demo")
        assert launcher.end() == 0
        assert not token.bearers()
    assert not list(sockets.iterdir())


TWO_CAMERAS = """
[[sessions]]
env = { session_name = "left" }
nodes = [{ name = "CAM", command = "exec sleep TOKEN" }]
[[sessions]]
env = { session_name = "right" }
nodes = [{ name = "CAM", command = "exec sleep TOKEN" }]
"""


def test_a_name_that_several_programs_have_is_told_with_their_own_numbers(
    tmp_path: Path, sockets: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with up(tmp_path, TWO_CAMERAS) as (launcher, token):
        token.wait_for_sleepers(2)
        wait_until(lambda: len(launched()) == 2, "the launcher")
        with pytest.raises(ControlError, match=r"^CAM may be left/CAM or right/CAM$"):
            connect().stop("CAM")
        with pytest.raises(ControlError, match="did you mean left/CAM or right/CAM"):
            connect().stop("rihgt/CAM")
        with up(tmp_path, SLEEPERS, name="one.toml") as (one, first):
            with up(tmp_path, SLEEPERS, name="two.toml") as (two, second):
                assert first.wait_for_sleepers(2)
                assert second.wait_for_sleepers(2)
                wait_until(lambda: len(connect().launched()) == 10, "all launchers")
                pids = {o["launcher"]: o["pid"] for o in connect().launched() if o["name"] == "b"}
                with pytest.raises(ControlError, match="choose one by its number") as caught:
                    connect().stop("b")
                for pid, child in pids.items():
                    assert f"b [{child}] of launcher [{pid}]" in str(caught.value)
                assert set(caught.value.suggestions) == set(map(str, pids.values()))
                show_processes(SimpleNamespace(program=None, json=False))
                shown = capsys.readouterr().out
                assert all(f"started by rosbase up [{pid}]:" in shown for pid in pids)
                connect().stop(str(pids[one.process.pid]))
                assert len(first.wait_for_sleepers(1)) == 1
                assert two.end(signal.SIGINT) == 0
            assert one.end(signal.SIGINT) == 0
        assert launcher.end(signal.SIGINT) == 0


def test_a_launcher_runs_without_a_control_socket_if_a_user_wants_it_so(
    tmp_path: Path, sockets: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with up(tmp_path, SLEEPERS, environment={"ROSBASE_CONTROL": "off"}) as (launcher, token):
        token.wait_for_sleepers(2)
        assert not sockets.exists()
        assert launcher.end(signal.SIGINT) == 0


def manager(phase: str) -> dict[str, Any]:
    return {"kind": "manager", "phase": phase}


@pytest.mark.parametrize(
    ("condition", "programs", "nodes", "is_met"),
    [
        (HANDSHAKE, [], [], False),
        (HANDSHAKE, [{"kind": "launcher", "phase": "running"}], [], False),
        (HANDSHAKE, [manager("starting")], [], False),
        (HANDSHAKE, [manager("handshake")], [], False),
        (HANDSHAKE, [manager("bringing up")], [], True),
        (HANDSHAKE, [manager("running"), manager("handshake")], [], False),
        (HANDSHAKE, [manager("stopping")], [], False),
        (HANDSHAKE, [{}], [], False),
        (ACTIVE, [manager("running")], [], False),
        (ACTIVE, [manager("running")], [{"state": "active"}], True),
        (ACTIVE, [manager("running")], [{"state": "active"}, {"state": "inactive"}], False),
    ],
)
def test_a_program_is_ready_when_all_of_it_is(
    condition: Condition,
    programs: list[dict[str, Any]],
    nodes: list[dict[str, Any]],
    *,
    is_met: bool,
) -> None:
    assert is_ready(condition, programs, nodes) == is_met
