"""Control sockets of real processes: with children, and after every kind of end."""

import os
import shutil
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from rosbase.control.folder import sockets
from support.control import Asker, offering, socket_of
from support.program import Program, running
from support.waiting import wait_until

PROGRAM = """
import os, sys, threading, time
from rosbase import (BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes,
                     LifecycleNode)

class Child(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.declare_parameter("zoom", 2)
        self.create_timer(0.05, self.talk)
        self.count = 0
    def talk(self):
        self.count += 1
        if self.count == 3:
            self.logger.warning("from the child")

class Handlers(BaseHandlers):
    def handle(self):
        if self.timestamp == 3:
            self.logger.info("ready")
            print("ready", flush=True)
            HOW[sys.argv[1]]()

def crash():
    os.abort()

def leave():
    os._exit(3)

def fail():
    raise ValueError("lens cap")

def fork():
    if os.fork() == 0:
        print("forked", os.getpid(), flush=True)
        time.sleep(60)
        os._exit(0)

def block():
    threading.Event().wait(60)

HOW = {"run": lambda: None, "crash": crash, "leave": leave, "fail": fail, "fork": fork,
       "block": block, "children": lambda: None}

if __name__ == "__main__":
    processes = None
    if sys.argv[1] == "children":
        processes = register_multiprocess_nodes({"eye": Child}, {"sleeper": "exec sleep 60"})
    BaseManager("app", handlers_class=Handlers, node_freq_hz=50).start_main_loop_timer(processes)
"""


def start(tmp_path: Path, how: str, **options: Any) -> Any:
    return running(tmp_path, PROGRAM, how, **options)


def path_of(program: Program) -> str:
    return socket_of(program.process.pid)


def folder() -> Path:
    return Path(os.environ["XDG_RUNTIME_DIR"], "rosbase")


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch, runtime_dir: str) -> None:
    """Keeps programs of the user out of the list of sockets, and removes what others left."""
    monkeypatch.setenv("ROSBASE_CONTROL_FOLDER", str(folder()))
    if folder().exists():
        shutil.rmtree(folder())


def test_a_program_is_asked_from_another_process_and_stopped(tmp_path: Path) -> None:
    with start(tmp_path, "run") as program:
        program.read_until("ready")
        with Asker(path_of(program)) as client:
            found = client.ask("process")
            assert found["pid"] == program.process.pid
            assert found["command"][-2:] == [str(tmp_path / "program.py"), "run"]
            assert client.ask("stop") == {"programs": ["/app"]}
            assert client.is_closed()
        status, _, err = program.end()
        assert status == 0, err
        assert not Path(path_of(program)).exists()


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_that_ends_it_takes_the_socket_along(tmp_path: Path, signum: int) -> None:
    with start(tmp_path, "run") as program:
        program.read_until("ready")
        with Asker(path_of(program)):
            _, status, _, err = program.stop(signum)
        assert status == 0, err
        assert "control" not in err
        assert not Path(path_of(program)).exists()


def test_an_exception_that_ends_it_takes_the_socket_along(tmp_path: Path) -> None:
    with start(tmp_path, "fail") as program:
        status, _, err = program.end()
        assert (status, "lens cap" in err) == (1, True)
        assert not Path(path_of(program)).exists()


@pytest.mark.parametrize("how", ["crash", "leave", "kill"])
def test_what_a_crash_leaves_behind_is_removed_by_the_next_start(tmp_path: Path, how: str) -> None:
    with start(tmp_path, "run" if how == "kill" else how) as program:
        program.read_until("ready")
        if how == "kill":
            program.process.kill()
        program.process.wait()
        assert Path(path_of(program)).exists()
    with pytest.raises(ConnectionRefusedError):
        Asker(path_of(program))
    with offering():
        wait_until(lambda: not Path(path_of(program)).exists(), "its removal")


def test_children_have_sockets_of_their_own_and_the_log_of_the_manager_has_their_records(
    tmp_path: Path,
) -> None:
    with start(tmp_path, "children") as program:
        program.read_until("ready")
        with Asker(path_of(program)) as client:
            wait_until(lambda: len(sockets()) == 2, "the node's socket")
            (told,) = client.ask("process")["programs"]
            children = {child["name"]: child for child in told["children"]}
            assert {name: child["running"] for name, child in children.items()} == {
                "eye": True,
                "sleeper": True,
            }
            assert client.ask("log", follow=True)["count"] >= 0
            texts: list[str] = []
            while "eye: from the child" not in texts:
                texts.append(client.read()[0]["event"]["text"])
        pid = children["eye"]["pid"]
        with Asker(socket_of(pid)) as client:
            (told,) = client.ask("process")["programs"]
            assert (told["kind"], told["name"], told["class"]) == ("node", "/eye", "Child")
            found = client.ask("parameter.set", node="eye", values={"zoom": 5})
            assert found["results"]["zoom"]["successful"]
        _, status, _, err = program.stop(signal.SIGTERM)
        assert status == 0, err
        assert not Path(path_of(program)).exists()
        assert not Path(socket_of(pid)).exists()


def test_a_program_whose_loop_blocks_answers(tmp_path: Path) -> None:
    with start(tmp_path, "block") as program:
        program.read_until("ready")
        with Asker(path_of(program)) as client:
            before = time.monotonic()
            assert client.ask("process")["programs"][0]["phase"] == "running"
            assert client.ask("statistics")
            assert time.monotonic() - before < 5


def test_a_forked_child_does_not_keep_the_socket(tmp_path: Path) -> None:
    with start(tmp_path, "fork", options=["-W", "ignore::DeprecationWarning"]) as program:
        assert program.process.stdout is not None
        # Which of the two comes first depends on the program's buffer only.
        lines = [program.process.stdout.readline().split() for _ in range(2)]
        (child,) = [int(line[1]) for line in lines if line[:1] == ["forked"]]
        open_there = [os.readlink(one) for one in Path(f"/proc/{child}/fd").iterdir()]
        assert not [one for one in open_there if "socket" in one or "eventpoll" in one]
        with Asker(path_of(program)) as client:
            client.ask("stop")
            assert client.is_closed()
        assert program.process.wait() == 0
        with pytest.raises(FileNotFoundError):
            Asker(path_of(program))
        os.kill(child, signal.SIGKILL)


def test_the_environment_turns_it_off_for_children_too(tmp_path: Path) -> None:
    with start(tmp_path, "children", env={"ROSBASE_CONTROL": "off"}) as program:
        program.read_until("ready")
        assert sockets() == []
        _, status, _, _ = program.stop(signal.SIGTERM)
        assert status == 0


def test_fifty_programs_at_once_have_fifty_sockets(tmp_path: Path) -> None:
    programs = []
    try:
        for number in range(50):
            place = tmp_path / str(number)
            place.mkdir()
            programs.append(Program(place, PROGRAM, "run"))
        for program in programs:
            program.read_until("ready")
            with Asker(path_of(program)) as client:
                assert client.hello["pid"] == program.process.pid
    finally:
        for program in programs:
            program.process.kill()
            program.process.communicate()
    with offering() as own:
        wait_until(lambda: os.listdir(folder()) == [Path(own).name], "the removal of all")


QUIET = """
import sys
from rosbase import BaseHandlers, BaseManager

class Handlers(BaseHandlers):
    def handle(self):
        self.manager.request_stop()

BaseManager("app", handlers_class=Handlers).start_main_loop_timer()
print(*sorted(name for name in sys.modules if name.startswith("rosbase.control")))
"""


def test_what_serves_clients_is_not_imported_until_one_comes(tmp_path: Path) -> None:
    with running(tmp_path, QUIET) as program:
        status, out, err = program.end()
    assert status == 0, err
    needed = ("folder", "programs", "recent_log", "server", "socket_file", "unheard")
    assert out.split() == ["rosbase.control", *(f"rosbase.control.{name}" for name in needed)]
