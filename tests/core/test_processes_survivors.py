"""Nothing survives its guardian, and what nobody could end is named by the next run."""

import ctypes
import os
import signal
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
from rosbase.processes import ChildProcesses, survivors
from rosbase.processes.guardian import MARK_VARIABLE
from rosbase.processes.mark import Mark
from rosbase.processes.survivors import find_survivors
from support.processes import Token, bearers_of_a_token, parent_of, state_of
from support.program import running
from support.waiting import wait_until

NAP = "sleep 9TOKEN"
PYTHON = f"{sys.executable} -c"
DAEMON = """
import os, sys, time
if os.fork(): os._exit(0)
os.setsid()
if os.fork(): os._exit(0)
os.chdir("/")
null = os.open("/dev/null", os.O_RDWR)
for fd in range(3): os.dup2(null, fd)
os.closerange(3, 256)
"""
KINDS: dict[str, tuple[str, int]] = {
    # A command, and how many of its processes sleep for a time that is a token.
    "the command itself": ("exec NAP", 1),
    "a background job of a shell that ends": ("NAP & sleep 0.3; exit 0", 1),
    "a shell with background jobs": ("NAP & NAP & NAP & wait", 3),
    "another session": ("setsid NAP & wait", 1),
    "another session in the foreground": ("setsid -w NAP", 1),
    "nohup": ("nohup NAP >/dev/null 2>&1 & wait", 1),
    "forked twice": ("(setsid NAP &) ; (setsid NAP &) ; NAP", 3),
    "a tree of six": (
        "setsid sh -c 'NAP & sh -c \"NAP & setsid NAP & wait\" & NAP & wait' & NAP",
        5,
    ),
    "a daemon in Python": (f"{PYTHON} '{DAEMON}time.sleep(9TOKEN)' ; NAP", 2),
    "deaf": ("setsid sh -c \"trap '' INT TERM HUP QUIT; NAP; NAP\" & NAP", 2),
    "stopped": ("setsid sh -c 'NAP & kill -STOP $$; NAP' & NAP", 2),
    "one that goes on forking": ("setsid sh -c 'while :; do NAP & sleep 0.02; done' & NAP", 5),
    "a parent of zombies": (
        "setsid perl -e 'fork or exit for 1..5; exec qw(NAP)' >/dev/null 2>&1 & NAP",
        2,
    ),
    "renamed": ("setsid perl -e '$0 = qq(kworker/9TOKEN); sleep 1000' & NAP", 2),
    "renamed, without an output": (
        "setsid perl -e '$0 = qq(kworker/9TOKEN); sleep 1000' >/dev/null 2>&1 & NAP",
        2,
    ),
    "without an environment": ("env -i setsid NAP >/dev/null 2>&1 & NAP", 2),
    "an heir of orphans": (
        f"setsid {PYTHON} 'import ctypes, subprocess; "
        "ctypes.CDLL(None).prctl(36, 1, 0, 0, 0); "
        'subprocess.call(["sh", "-c", "setsid NAP & setsid NAP &"]); '
        'subprocess.call(["NAP".split()[0], "NAP".split()[1]])\' & NAP',
        5,
    ),
    "a pipeline of sessions": ("setsid NAP | setsid NAP | setsid NAP", 3),
}


@pytest.fixture
def token() -> Iterator[Token]:
    with bearers_of_a_token() as given:
        yield given


Register = Callable[..., ChildProcesses]


@pytest.fixture
def register(caplog: pytest.LogCaptureFixture) -> Iterator[Register]:
    caplog.set_level("INFO", logger="rosbase")
    started: list[ChildProcesses] = []

    def start(*args: Any, **kwargs: Any) -> ChildProcesses:
        started.append(register_multiprocess_nodes(*args, **kwargs))
        return started[-1]

    yield start
    for processes in started:
        shutdown_multiprocess_nodes(processes)


def spell(command: str, token: Token) -> str:
    return command.replace("NAP", NAP).replace("9TOKEN", token.text)


def guardian_of(processes: ChildProcesses, name: str) -> int:
    wait_until(lambda: processes[name].pid, f"the start of {name}")
    pid = processes[name].pid
    assert pid is not None
    return parent_of(pid)


def kill(pid: int, signum: int = signal.SIGKILL) -> None:
    os.kill(pid, signum)


def own_children() -> set[int]:
    """The children of this process, those included that wait to be reaped."""
    tasks = Path("/proc/self/task").glob("*/children")
    return {int(pid) for task in tasks for pid in task.read_text().split()}


@pytest.mark.parametrize("kind", KINDS)
def test_when_a_guardian_is_killed_all_that_it_guarded_ends(
    kind: str, register: Register, token: Token
) -> None:
    command, number = KINDS[kind]
    processes = register({}, {"x": spell(command, token), "other": "sleep 1000"})
    guardian = guardian_of(processes, "x")
    wait_until(
        lambda: sum("sh -c" not in text for text in token.bearers().values()) >= number, kind
    )
    kill(guardian)
    token.wait_until_gone(3.0)
    wait_until(lambda: not processes["x"].is_alive, "the news of it")
    assert processes["other"].is_alive
    assert own_children() == {guardian_of(processes, "other")}, "nobody waits to be reaped"


def test_a_process_whose_main_thread_has_ended_is_not_taken_for_a_dead_one(
    register: Register, tmp_path: Path
) -> None:
    note = tmp_path / "pid"
    code = (
        "import ctypes, os, threading, time;"
        " threading.Thread(target=time.sleep, args=(1000,)).start();"
        f' open("{note}", "w").write(str(os.getpid())); ctypes.CDLL(None).pthread_exit(None)'
    )
    processes = register({}, {"x": f"setsid {PYTHON} '{code}'; sleep 1000"})
    guardian = guardian_of(processes, "x")
    wait_until(lambda: note.exists() and note.read_text(), "its number")
    pid = int(note.read_text())
    try:
        wait_until(lambda: state_of(pid) == "Z", "the end of its main thread")
        kill(guardian)
        wait_until(lambda: state_of(pid) == "", "its end", 3.0)
    finally:
        if state_of(pid):
            kill(pid)


def test_children_of_a_program_that_is_a_child_itself_end_with_its_guardian(
    register: Register, token: Token, tmp_path: Path
) -> None:
    program = tmp_path / "inner.py"
    program.write_text(
        textwrap.dedent(
            f"""
            import time
            from rosbase import register_multiprocess_nodes
            if __name__ == "__main__":
                register_multiprocess_nodes({{}}, {{"y": "setsid sleep {token.text}"}})
                time.sleep({token.text})
            """
        )
    )
    processes = register({}, {"x": f"setsid {sys.executable} {program}"})
    guardian = guardian_of(processes, "x")
    (inner,) = token.wait_for_sleepers(1)
    kill(guardian)
    token.wait_until_gone(3.0)
    wait_until(lambda: not processes["x"].is_alive, "the news of it")
    assert state_of(inner) == ""
    assert not own_children()


def is_subreaper() -> bool:
    answer = ctypes.c_int()
    ctypes.CDLL(None).prctl(37, ctypes.byref(answer), 0, 0, 0)
    return bool(answer.value)


def test_a_process_adopts_orphans_only_while_it_has_children() -> None:
    assert not is_subreaper()
    first = register_multiprocess_nodes({}, {"x": "sleep 1000"})
    second = register_multiprocess_nodes({}, {"y": "sleep 1000"})
    shutdown_multiprocess_nodes(first)
    assert is_subreaper()
    shutdown_multiprocess_nodes(second)
    assert not is_subreaper()


BESIDE = """
import os, subprocess, sys, time
from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
if __name__ == "__main__":
    processes = register_multiprocess_nodes({}, {"x": "setsid sleep 9TOKEN & sleep 9TOKEN"})
    own = subprocess.Popen(["sh", "-c", "sleep 0.5; exit 7"])
    # A daemon: this process adopts it, but it is none of its business.
    subprocess.run("setsid sleep 9TOKEN >/dev/null 2>&1 & exit 0", shell=True)
    while not processes["x"].pid:
        time.sleep(0.01)
    print("running", processes["x"].pid, sep="\\n", flush=True)
    while processes["x"].is_alive:
        time.sleep(0.01)
    print(own.wait())
    shutdown_multiprocess_nodes(processes)
    print("returned")
"""


def test_a_daemon_and_a_subprocess_of_the_program_are_left_alone(
    token: Token, tmp_path: Path
) -> None:
    with running(tmp_path, BESIDE.replace("9TOKEN", token.text)) as program:
        program.read_until("running")
        token.wait_for_sleepers(3)
        assert program.process.stdout is not None
        kill(parent_of(int(program.process.stdout.readline())))
        status, out, _ = program.end()
        assert (status, out) == (0, "7\nreturned\n")
        assert len(token.sleepers()) == 1, "the daemon"


GUARDIAN = "python\0-I\0-S\0/lib/rosbase/processes/guardian.py\0007\0{}\0-1\0/bin/sh\0-c\0nap"
NAPPING = "sleep\0001000"
MARK = Mark((1 << 60) + 5, (20, 111), "0000abcd", "arm")
LABEL = f"Max file locks            {(1 << 60) + (0xABCD << 40) + 5} unlimited locks"


@pytest.mark.parametrize(
    ("parent", "environment", "limits", "named"),
    [
        (1, f"{MARK_VARIABLE}={MARK}", "", "arm"),
        (1, "", LABEL, "a child"),
        (1, "", "", None),
        (30, f"{MARK_VARIABLE}={MARK}", LABEL, None),
        (40, f"{MARK_VARIABLE}={MARK}", LABEL, None),
        (1, f"{MARK_VARIABLE}={evolve(MARK, manager=(40, 444))}", LABEL, None),
        (1, f"{MARK_VARIABLE}={evolve(MARK, manager=(40, 443))}", LABEL, "arm"),
        (1, f"{MARK_VARIABLE}={evolve(MARK, program='0000abce')}", "", None),
    ],
    ids=[
        "an orphan with its environment",
        "one without",
        "one of somebody else",
        "one that a guardian has",
        "one that a manager has",
        "one whose manager is about to adopt it",
        "one whose manager's number is another's by now",
        "one of another program",
    ],
)
def test_survivors_are_orphans_of_this_program(
    monkeypatch: pytest.MonkeyPatch,
    parent: int,
    environment: str,
    limits: str,
    named: str | None,
) -> None:
    """30 and 41 are guardians: that of a manager that is dead, and one of the manager 40."""
    parents = {1: 0, 30: 1, 40: 1, 41: 40, 50: parent}
    commands = {30: GUARDIAN.format(20), 40: "python", 41: GUARDIAN.format(40), 50: NAPPING}
    files = {(pid, "cmdline"): text for pid, text in commands.items()}
    files |= {(1, "cmdline"): "init", (50, "environ"): environment, (50, "limits"): limits}
    stats = {
        pid: f"S {parents[pid]} {'0 ' * 15}1 0 {pid * 11 + (pid == 40) * 4}".encode().split()
        for pid in parents
    }
    monkeypatch.setattr(survivors, "everybody", lambda: stats)
    monkeypatch.setattr(survivors, "read_of", lambda *key: files.get(key, "").encode())
    found = [(survivor.pid, survivor.name) for survivor in find_survivors(MARK.program)]
    assert found == ([(50, named)] if named else [])


TOGETHER = """
import os, time
from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
if __name__ == "__main__":
    commands = {} if os.path.exists("over") else {"arm": COMMAND}
    processes = register_multiprocess_nodes({}, commands or {"arm": "sleep 0.2"})
    while processes["arm"].is_alive:
        time.sleep(0.01)
    shutdown_multiprocess_nodes(processes)
"""


@pytest.mark.parametrize(
    ("command", "number", "name"),
    [
        ("setsid NAP & exec NAP", 2, "arm"),
        ("setsid NAP >/dev/null 2>&1 & setsid NAP & exec NAP", 3, "arm"),
        (KINDS["without an environment"][0].replace("& NAP", "& exec NAP"), 2, "a child"),
    ],
)
def test_when_manager_and_guardian_are_killed_together_the_next_run_names_who_is_left(
    token: Token, tmp_path: Path, command: str, number: int, name: str
) -> None:
    app = TOGETHER.replace("COMMAND", repr(spell(command, token)))
    with running(tmp_path, app) as program:
        sleepers = token.wait_for_sleepers(number)
        (direct,) = (pid for pid in sleepers if parent_of(parent_of(pid)) == program.process.pid)
        kill(program.process.pid, signal.SIGSTOP)
        kill(guardian := parent_of(direct))
        kill(program.process.pid)
        wait_until(lambda: state_of(guardian) == "", "the end of the guardian")
        left = token.wait_for_sleepers(number - 1)
        assert direct not in left
        # Inside, because it kills the survivors when it is left.
        (tmp_path / "over").touch()
        (tmp_path / "elsewhere").mkdir()
        again = app.replace('"over"', repr(str(tmp_path / "over")))
        for folder, is_named in ((tmp_path, True), (tmp_path / "elsewhere", False)):
            with running(folder, again) as later:
                _, _, err = later.end()
            for pid in left:
                line = f"{name}: an earlier run has left process {pid} behind: sleep {token.text}"
                assert (line in err) == is_named
        assert token.sleepers() == left, "they are named, and not ended"


def test_a_guardian_that_is_about_to_end_everything_leaves_nobody_to_be_named(
    token: Token, tmp_path: Path
) -> None:
    deaf = f"trap '' INT TERM; {NAP}; {NAP}"
    app = TOGETHER.replace("COMMAND", repr(spell(deaf, token)))
    with running(tmp_path, app) as program:
        token.wait_for_sleepers(1)
        kill(program.process.pid)
        (tmp_path / "over").touch()
        again = app.replace('"over"', repr(str(tmp_path / "over")))
        with running(tmp_path, again) as second:
            _, _, err = second.end()
        assert "earlier run" not in err
    token.wait_until_gone(3.0)
