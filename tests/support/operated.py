"""Programs that run, and the commands that look at them and operate them."""

import subprocess
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest

from rosbase.control import connect
from support.command import ROSBASE
from support.program import Program, running
from support.waiting import wait_until

APP = """
from rosbase import BaseHandlers, BaseManager, BaseNode, LifecycleNode, ParameterSpec
from rosbase.messages import Point
from rosbase.messages.std_srvs import SetBool


class Robot(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.position = self.create_publisher(Point, "position")
        self.create_subscription(Point, "goal", lambda goal: print("goal", goal.x, flush=True))
        self.create_service(SetBool, "enable", self.enable)
        self.declare_parameter("speed", 1.5)
        self.declare_parameter("names", ["a", "b"])

    def enable(self, request, response):
        if not request.data:
            raise RuntimeError("no")
        return SetBool.Response(True, "was off")


class Arm(LifecycleNode):
    def on_configure(self, state):
        self.logger.info("configured the arm")
        return super().on_configure(state)


class Handlers(BaseHandlers):
    def handle(self):
        self.node(Robot).position.publish(Point(self.timestamp * 0.5, 0.0, -1.0))
        if self.timestamp == 5:
            self.manager.logger.warning("five ticks")
            print("ready", flush=True)


manager = BaseManager("app", {"robot": Robot, "arm": Arm}, {}, Handlers, node_freq_hz=100)
manager.start_main_loop_timer()
"""
"""A manager with a lifecycle node and a plain one, which has topics, a service and parameters."""

LISTENER = """
from rosbase import BaseNode
from rosbase.messages import Point

node = BaseNode(node_name="listener")
node.create_subscription(Point, "position", print)
node.create_subscription(Point, "goal", print)
node.create_timer(0.1, lambda: print("ready", flush=True))
node.start_spin_standalone()
"""
"""A lone node that subscribes to the topics of the other program, on a bus of its own."""


class Robots:
    """Running programs, apart from those of other tests."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self._folder = folder
        self._stack = stack

    def start(self, source: str, *arguments: str, until: str = "ready", **options: Any) -> Program:
        """Starts a program, and waits until it has printed that line."""
        folder = self._folder / uuid.uuid4().hex[:6]
        folder.mkdir()
        program = self._stack.enter_context(running(folder, source, *arguments, **options))
        program.read_until(until)
        return program

    def start_command(self, *words: str) -> "subprocess.Popen[str]":
        """Starts a command; it is killed at the end."""
        return self.start_process([ROSBASE, *words])

    def start_process(self, command: list[str], cwd: Path | None = None) -> "subprocess.Popen[str]":
        """Starts a process; it is killed at the end."""
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=cwd
        )
        self._stack.enter_context(process)
        self._stack.callback(process.kill)
        return process


def run(*words: str, status: int = 0) -> str:
    """Runs a command; gives its output if the status is that one."""
    out, err = run_both(*words, status=status)
    assert status or not err, err
    return out if status == 0 else err


def run_both(*words: str, status: int = 0) -> tuple[str, str]:
    """Runs a command to its end; gives what it has written to stdout and to stderr."""
    done = subprocess.run(
        [ROSBASE, *words], capture_output=True, text=True, timeout=40, check=False
    )
    assert done.returncode == status, (words, done)
    assert "Traceback" not in done.stderr, done.stderr
    return done.stdout, done.stderr


@contextmanager
def robots_in(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    """Gives a place for programs of a test's own; nothing of them is left at the end."""
    with tempfile.TemporaryDirectory(prefix="rosbase-") as sockets, ExitStack() as stack:
        # The path of a socket is short, and that of a test's folder may be long.
        monkeypatch.setenv("XDG_RUNTIME_DIR", sockets)
        monkeypatch.setenv("ROSBASE_CONTROL_FOLDER", f"{sockets}/rosbase")
        yield Robots(folder, stack)


def wait_for_programs(*names: str) -> None:
    """Waits until all of them run and answer."""

    def running_names() -> set[str]:
        found = connect().processes()
        return {one["name"].lstrip("/") for process in found for one in process["programs"]}

    wait_until(lambda: set(names) <= running_names(), f"the programs {', '.join(names)}")


def pid_of(program: Program) -> int:
    """The pid of a program, as the commands show it."""
    return program.process.pid
