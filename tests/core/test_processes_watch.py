"""Children under supervision: what they write, how they end, when they start again."""

import resource
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    BaseHandlers,
    BaseManager,
    BaseNode,
    RestartPolicy,
    register_multiprocess_nodes,
    shutdown_multiprocess_nodes,
)
from rosbase.errors import ConfigurationError
from rosbase.processes import ChildProcesses
from support.processes import members_of_session
from support.waiting import wait_until

Register = Callable[..., ChildProcesses]

UNTIL_STOPPED = "until grep -q '^State:.T' /proc/$$/status; do sleep 0.01; done"
"""Waits for the shell to be stopped, in a process that it has begun."""


@pytest.fixture
def register(caplog: pytest.LogCaptureFixture) -> Iterator[Register]:
    """Registers children that end with the test; what they write is in `caplog`."""
    caplog.set_level("INFO", logger="rosbase")
    started: list[ChildProcesses] = []

    def start(*args: Any, **kwargs: Any) -> ChildProcesses:
        started.append(register_multiprocess_nodes(*args, **kwargs))
        return started[-1]

    yield start
    for processes in started:
        shutdown_multiprocess_nodes(processes)


def sleepers(session: int) -> int:
    """How many of a session sleep, as commands of these tests do."""
    commands = [Path(f"/proc/{pid}/cmdline").read_bytes() for pid in members_of_session(session)]
    return sum(command.startswith(b"sleep") for command in commands)


def wait_for_end(processes: ChildProcesses) -> None:
    for name, child in processes.items():
        wait_until(lambda child=child: not child.is_alive, f"the end of {name}")  # type: ignore[misc]  # mypy infers no default of a lambda


def test_output_is_logged_line_by_line_with_the_name_of_the_child(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    wait_for_end(register({}, {"a": "echo one; echo two >&2; printf three"}))
    assert caplog.messages[:3] == ["a: one", "a: two", "a: three"]


@pytest.mark.parametrize(
    ("command", "code", "text"),
    [
        ("exit 3", 3, "x: ended with status 3"),
        ("true", 0, "x: ended with status 0"),
        ("kill -SEGV $$", -signal.SIGSEGV, "x: was ended by SIGSEGV"),
        ("(sleep 0.1; exit 4) &", 4, "x: ended with status 4"),
        ("/no/such/command", 127, "x: ended with status 127"),
        ("yes | head -n 1", 0, "x: ended with status 0"),
    ],
)
def test_an_end_is_reported_with_its_status(
    register: Register, caplog: pytest.LogCaptureFixture, command: str, code: int, text: str
) -> None:
    processes = register({}, {"x": command})
    wait_for_end(processes)
    wait_until(lambda: text in caplog.messages, text)
    assert processes["x"].exit_code == code
    level = next(r.levelname for r in caplog.records if r.getMessage() == text)
    assert level == ("ERROR" if code else "INFO")


def test_a_failed_command_is_reported_at_once_though_it_left_others_behind(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    processes = register({}, {"x": "sleep 1000 & exit 5"})
    wait_until(lambda: "x: ended with status 5" in caplog.messages, "the report")
    wait_for_end(processes)
    assert caplog.messages.count("x: ended with status 5") == 1


def test_ten_megabytes_without_a_newline_neither_block_nor_grow_the_manager(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wait_for_end(register({}, {"x": "head -c 10000000 /dev/zero | tr '\\0' 'a'"}))
    after_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert after_kb - before_kb < 2_000
    assert caplog.messages[0] == f"x: {'a' * 4096} ... 9995904 more bytes"


def test_bytes_that_are_not_text_neither_block_nor_grow_the_manager(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    wait_for_end(register({}, {"x": "printf 'a\\377b\\n'; head -c 50000000 /dev/urandom"}))
    after_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    # `caplog` keeps the lines that are logged.
    assert after_kb - before_kb < 25_000
    assert caplog.messages[0] == "x: a\\xffb"
    assert "more lines" in caplog.text


def test_a_child_that_closes_its_output_is_still_watched(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    wait_for_end(register({}, {"x": "exec >&- 2>&-; sleep 0.1; exit 6"}))
    wait_until(lambda: "x: ended with status 6" in caplog.messages, "the report")


def test_a_manager_keeps_its_rate_beside_a_child_that_floods_its_output(
    register: Register,
) -> None:
    processes = register({}, {"flood": "yes"})

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            if self.timestamp == 200:
                self.manager.request_stop()

    manager = BaseManager(handlers_class=Handlers, node_freq_hz=100)
    start = time.monotonic()
    manager.start_main_loop_timer(processes)
    assert time.monotonic() - start < 5.0
    assert manager.loop_stats.overruns < 150


@pytest.mark.parametrize(
    ("policy", "command", "starts"),
    [
        ("never", "exit 1", 1),
        (RestartPolicy("on-failure", limit=2, first_delay_s=0.01), "exit 1", 3),
        (RestartPolicy("on-failure", limit=2, first_delay_s=0.01), "exit 0", 1),
        (RestartPolicy("always", limit=2, first_delay_s=0.01), "exit 0", 3),
    ],
)
def test_a_child_is_started_again_as_its_policy_says_and_no_more(
    register: Register,
    caplog: pytest.LogCaptureFixture,
    tmp_path: Path,
    policy: Any,
    command: str,
    starts: int,
) -> None:
    log = tmp_path / "starts"
    processes = register({}, {"x": f"echo start >> {log}; {command}"}, restart={"x": policy})
    ends = f"x: ended with status {command[-1]}"
    wait_until(lambda: caplog.messages.count(ends) == starts, f"{starts} ends")
    wait_for_end(processes)
    assert len(log.read_text().split()) == starts
    gave_up = "x: not started again: 2 in a row"
    if starts == 3:
        wait_until(lambda: gave_up in caplog.messages, gave_up)
    assert (gave_up in caplog.messages) == (starts == 3)


def test_a_stop_while_a_restart_is_due_keeps_the_child_stopped(
    register: Register, caplog: pytest.LogCaptureFixture
) -> None:
    policy = RestartPolicy("always", first_delay_s=60.0, longest_delay_s=60.0)
    processes = register({}, {"x": "true"}, restart=policy)
    wait_until(lambda: "starting again" in caplog.text, "the plan")
    shutdown_multiprocess_nodes(processes)
    assert not processes["x"].is_alive


@pytest.mark.parametrize(
    ("command", "code"),
    [
        ("trap '' INT TERM; echo up; while true; do sleep 1000; done", -signal.SIGKILL),
        (f"({UNTIL_STOPPED}; echo up) & kill -STOP $$", -signal.SIGKILL),
        ("trap 'exit 0' TERM; trap '' INT; echo up; while true; do sleep 0.01; done", 0),
    ],
    ids=["deaf to all but SIGKILL", "stopped", "heeds SIGTERM"],
)
def test_who_does_not_heed_a_signal_gets_the_next(
    register: Register, caplog: pytest.LogCaptureFixture, command: str, code: int
) -> None:
    processes = register({}, {"x": command})
    wait_until(lambda: "x: up" in caplog.messages, "its first line")
    shutdown_multiprocess_nodes(processes)
    assert processes["x"].exit_code == code
    assert ("x: had to be killed" in caplog.messages) == (code < 0)


@pytest.mark.parametrize(
    "command", ["exec sleep 1000", "sleep 1000 | cat", "sleep 1000 & sleep 1000", "sleep 1000 &"]
)
def test_when_a_guardian_is_killed_all_of_its_command_is(
    register: Register, caplog: pytest.LogCaptureFixture, command: str
) -> None:
    processes = register({}, {"x": f"echo up; {command}"})
    wait_until(lambda: "x: up" in caplog.messages, "its start")
    # What it writes may come before the news that it has started.
    wait_until(lambda: processes["x"].pid, "the news of its start")
    pid = processes["x"].pid
    assert pid is not None
    wait_until(lambda: sleepers(pid) == command.count("sleep"), "all of it")
    assert processes._supervisor is not None
    processes._supervisor._lives[0]._guardian.kill()
    wait_for_end(processes)
    wait_until(lambda: "x: was ended by SIGKILL" in caplog.messages, "the report")
    wait_until(lambda: not members_of_session(pid), "the end of all")


def test_the_managers_logger_takes_over(
    register: Register, caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    gate = tmp_path / "gate"
    processes = register(
        {}, {"x": f"until test -e {gate}; do sleep 0.01; done; echo late; sleep 1000"}
    )

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            gate.touch()
            if "x: late" in caplog.messages:
                self.manager.request_stop()

    BaseManager("boss", handlers_class=Handlers).start_main_loop_timer(processes)
    assert {r.name for r in caplog.records if r.getMessage() == "x: late"} == {"rosbase.boss"}


class Local(BaseNode):
    pass


def _local_class() -> type[BaseNode]:
    class Hidden(BaseNode):
        pass

    return Hidden


@pytest.mark.parametrize(
    ("nodes", "commands", "restart", "message"),
    [
        ({"a": Local}, {"a": "true"}, "never", "'a' is the name of a node and of a command"),
        ({}, {"a": ["true"]}, "never", "command 'a' is a text for the shell"),
        ({}, {"a": "true"}, "sometimes", "one of never, on-failure, always, not 'sometimes'"),
        ({}, {"a": "true"}, {"b": "always"}, "no child is called b"),
        ({"a": _local_class()}, {}, "never", "node 'a': another process cannot find"),
        ({"a": lambda: None}, {}, "never", "node 'a': another process cannot find"),
    ],
)
def test_what_cannot_be_registered_is_refused_in_one_line_and_nothing_starts(
    nodes: Any, commands: Any, restart: Any, message: str
) -> None:
    with pytest.raises(ConfigurationError, match=message) as refusal:
        register_multiprocess_nodes(nodes, {"z": "sleep 1000"} | commands, restart=restart)
    assert "\n" not in str(refusal.value)


def test_no_children_at_all_are_fine() -> None:
    processes = register_multiprocess_nodes({}, {})
    assert dict(processes) == {}
    shutdown_multiprocess_nodes(processes)
    shutdown_multiprocess_nodes(None)


def test_a_python_that_cannot_be_started_is_an_error_and_leaves_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("multiprocessing.spawn._python_exe", b"/no/such/python")
    with pytest.raises(FileNotFoundError):
        register_multiprocess_nodes({}, {"x": "true"})
