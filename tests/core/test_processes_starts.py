"""A start that fails half-way leaves no process, no thread and no descriptor."""

import errno
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    BaseNode,
    RestartPolicy,
    register_multiprocess_nodes,
    shutdown_multiprocess_nodes,
)
from rosbase.processes import launch
from support.processes import parent_of
from support.program import running
from support.waiting import wait_until


class Node(BaseNode):
    """A node that another process can find."""


NODES = {"n": Node, "m": Node}
COMMANDS = {"c": "sleep 1000", "d": "sleep 1000"}


def fail_after(number: int, function: Callable[..., Any], error: BaseException) -> Any:
    """The function, which raises that error from its nth call on."""
    calls: list[None] = []

    def replacement(*args: Any, **kwargs: Any) -> Any:
        calls.append(None)
        if len(calls) > number:
            raise error
        return function(*args, **kwargs)

    return replacement


@pytest.mark.parametrize("number", range(5))
def test_if_there_are_no_more_threads_nothing_is_left(
    number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    # One of the supervisor's, two for the link of each node.
    start = fail_after(number, threading.Thread.start, RuntimeError("can't start new thread"))
    monkeypatch.setattr(threading.Thread, "start", start)
    with pytest.raises(OSError, match="can't start new thread") as refusal:
        register_multiprocess_nodes(NODES, COMMANDS)
    assert refusal.value.errno == errno.EAGAIN


@pytest.mark.parametrize("number", range(4))
def test_if_there_are_no_more_processes_nothing_is_left(
    number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    error = BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable")
    monkeypatch.setattr(subprocess, "Popen", fail_after(number, subprocess.Popen, error))
    with pytest.raises(BlockingIOError):
        register_multiprocess_nodes(NODES, COMMANDS)


@pytest.mark.parametrize("function", ["os.pipe", "socket.socketpair", "os.openpty"])
@pytest.mark.parametrize("number", range(4))
def test_if_there_are_no_more_descriptors_nothing_is_left(
    number: int, function: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    error = OSError(errno.EMFILE, "Too many open files")
    module, name = function.split(".")
    original = getattr(__import__(module), name)
    monkeypatch.setattr(function, fail_after(number, original, error))
    try:
        processes = register_multiprocess_nodes(NODES, COMMANDS, pty=True)
    except OSError:
        return
    # A terminal takes no pipe.
    assert function == "os.pipe"
    assert number
    monkeypatch.undo()
    shutdown_multiprocess_nodes(processes)


def test_if_it_is_interrupted_nothing_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    interrupted = fail_after(2, launch.start_guarded, KeyboardInterrupt())
    monkeypatch.setattr(launch, "start_guarded", interrupted)
    with pytest.raises(KeyboardInterrupt):
        register_multiprocess_nodes(NODES, COMMANDS)


SCARCE = """
import os, resource, signal, sys, threading
from rosbase import BaseNode, register_multiprocess_nodes, shutdown_multiprocess_nodes

class Node(BaseNode):
    pass

def descriptors():
    return {fd: os.readlink(f"/proc/self/fd/{fd}") for fd in os.listdir("/proc/self/fd")[:-1]}

def is_alone():
    with open("/proc/thread-self/children") as file:
        return threading.active_count() == 1 and not file.read()

def attempt():
    try:
        # What is in the background ends at once.
        processes = register_multiprocess_nodes({"n": Node}, {"c": "sleep 1000 &"}, pty=["c"])
    except OSError as error:
        return error.strerror
    shutdown_multiprocess_nodes(processes)
    return "started"

def try_with(kind, limit):
    before = descriptors()
    hard = resource.getrlimit(kind)[1]
    resource.setrlimit(kind, (limit, hard))
    try:
        answer = attempt()
    finally:
        resource.setrlimit(kind, (hard, hard))
    after = descriptors()
    assert before == after, (limit, before, after)
    assert is_alone(), limit
    return answer
"""


@pytest.mark.once
@pytest.mark.parametrize("first", range(4))
def test_a_limit_of_descriptors_wherever_it_strikes_leaves_nothing(
    tmp_path: Path, first: int
) -> None:
    app = """
    if __name__ == "__main__":
        # So that what is imported at the first use is there.
        assert attempt() == "started"
        used = len(descriptors()) + 1
        answers = [try_with(resource.RLIMIT_NOFILE, used + n) for n in range(FIRST, 36, 4)]
        print(answers[0], answers[-1], set(answers), sep="\\n")
    """
    with running(
        tmp_path, SCARCE + app.replace("FIRST", str(first)).replace("\n    ", "\n")
    ) as program:
        status, out, err = program.end()
        assert not program.family()
    assert status == 0, err
    scarce, enough, answers = out.splitlines()
    assert (scarce, enough) == ("Too many open files", "started")
    assert eval(answers) == {scarce, enough}


AS_A_USER = """
def tasks_of(user):
    found = 0
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            status = dict(
                line.split(":\\t", 1) for line in open(f"/proc/{name}/status") if ":\\t" in line
            )
        except OSError:
            continue
        if int(status["Uid"].split()[0]) == user:
            found += int(status["Threads"])
    return found

if __name__ == "__main__":
    if os.getuid() == 0:
        # For root there is no limit of processes, nor for whoever may change limits.
        import ctypes
        for capability in (21, 24):
            ctypes.CDLL(None).prctl(24, capability, 0, 0, 0)
        os.setresuid(100_000 + os.getpid(), 0, 0)
        os.execv(sys.executable, [sys.executable, *sys.argv])
    assert attempt() == "started"
    used = tasks_of(os.getuid())
    answers = [try_with(resource.RLIMIT_NPROC, used + n) for n in range(12)]
    print(answers[0], answers[-1], len(set(answers)), sep="\\n")
"""


@pytest.mark.once
def test_a_limit_of_processes_wherever_it_strikes_leaves_nothing(tmp_path: Path) -> None:
    with running(tmp_path, SCARCE + AS_A_USER) as program:
        status, out, err = program.end()
        assert not program.family()
    assert status == 0, err
    first, last, _ = out.splitlines()
    assert (first, last) == ("can't start new thread", "started"), err


def test_a_guardian_that_cannot_fork_says_so_and_the_child_counts_as_failed(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    # As it is, but without a process to give.
    guardian = tmp_path / "guardian.py"
    original = Path(launch.GUARDIAN).read_text()
    guardian.write_text(original.replace("os.fork()", "open('/no/such/process')"))
    monkeypatch.setattr(launch, "GUARDIAN", str(guardian))
    policy = RestartPolicy("on-failure", limit=1, first_delay_s=0.0)
    processes = register_multiprocess_nodes({}, {"x": "true"}, restart=policy)
    wait_until(lambda: "x: not started again: 1 in a row" in caplog.messages, "two tries")
    shutdown_multiprocess_nodes(processes)
    assert caplog.messages.count("x: cannot be started: No such file or directory") == 2
    assert processes["x"].exit_code == 126
    assert "Traceback" not in caplog.text


IGNORES = """
import signal, time

def end(*_):
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    time.sleep(0.6)
    raise SystemExit(0)

signal.signal(signal.SIGINT, end)
print("ready", flush=True)
while True:
    signal.pause()
"""


def test_a_program_that_ignores_signals_while_it_ends_is_given_its_time(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A guardian that is slow to look at the program after it has sent a signal.
    guardian = tmp_path / "guardian.py"
    slow = "_ignoring_absence(os.killpg, self._command, number); time.sleep(0.2)"
    original = Path(launch.GUARDIAN).read_text()
    quick = "_ignoring_absence(os.killpg, self._command, number)"
    assert original.count(quick) == 1
    guardian.write_text(original.replace(quick, slow))
    monkeypatch.setattr(launch, "GUARDIAN", str(guardian))
    program = tmp_path / "program.py"
    program.write_text(IGNORES)
    caplog.set_level("INFO")
    processes = register_multiprocess_nodes({}, {"x": f"exec {sys.executable} {program}"})
    wait_until(lambda: "x: ready" in caplog.messages, "its handler")
    shutdown_multiprocess_nodes(processes)
    assert processes["x"].exit_code == 0
    assert "x: had to be killed" not in caplog.messages


DELETED = """
import os, sys
from rosbase import BaseNode, register_multiprocess_nodes, shutdown_multiprocess_nodes

class Node(BaseNode):
    pass

if __name__ == "__main__":
    os.mkdir(sys.argv[1])
    os.chdir(sys.argv[1])
    os.rmdir(sys.argv[1])
    before = os.listdir("/proc/self/fd")
    try:
        register_multiprocess_nodes({"n": Node}, {"c": "sleep 1000"})
    except OSError as error:
        print(type(error).__name__, error.strerror)
    print(os.listdir("/proc/self/fd") == before, open("/proc/thread-self/children").read())
    processes = register_multiprocess_nodes({}, {"c": "echo here; sleep 1000"})
    while not processes["c"].pid:
        pass
    shutdown_multiprocess_nodes(processes)
    # A shell that is just starting another process notices SIGINT only when that one has ended.
    print(processes["c"].exit_code in (-2, -15))
"""


def test_a_node_cannot_be_started_in_a_folder_that_is_deleted_and_a_command_can(
    tmp_path: Path,
) -> None:
    with running(tmp_path, DELETED, str(tmp_path / "gone")) as program:
        status, out, err = program.end()
        assert not program.family()
    assert status == 0, err
    assert out.splitlines() == [
        "FileNotFoundError node 'n': the working directory does not exist any more",
        "True ",
        "True",
    ]


def test_a_node_that_cannot_be_started_again_is_tried_as_often_as_its_policy_says(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    monkeypatch.chdir(folder)
    policy = RestartPolicy("always", limit=2, first_delay_s=0.0)
    processes = register_multiprocess_nodes({"n": Node}, {}, restart=policy)
    wait_until(lambda: processes["n"].pid, "its start")
    folder.rmdir()
    pid = processes["n"].pid
    assert pid is not None
    os.kill(parent_of(pid), 9)
    wait_until(lambda: "n: not started again: 2 in a row" in caplog.messages, "two tries")
    shutdown_multiprocess_nodes(processes)
    monkeypatch.chdir(tmp_path)
    assert caplog.text.count("the working directory does not exist any more") == 2


def test_a_signal_finds_no_guardian_without_handlers(tmp_path: Path) -> None:
    app = """
    import os, signal
    from pathlib import Path
    from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
    if __name__ == "__main__":
        before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
        processes = register_multiprocess_nodes({}, {"child": "echo begun; sleep 1000"})
        for pid in os.listdir("/proc"):
            try:
                stat = Path("/proc", pid, "stat").read_text()
                parent = int(stat.rpartition(")")[2].split()[1])
            except (OSError, ValueError):
                continue
            if parent == os.getpid():
                os.kill(int(pid), signal.SIGINT)
        print(signal.pthread_sigmask(signal.SIG_BLOCK, ()) == before)
        shutdown_multiprocess_nodes(processes)
    """
    for _ in range(5):
        with running(tmp_path, app) as program:
            status, out, err = program.end()
        assert (status, out) == (0, "True\n")
        assert "Traceback" not in err
