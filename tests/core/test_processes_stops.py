"""A stop that comes from two sides: to a child and to its manager, in either order."""

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rosbase import (
    BaseHandlers,
    BaseManager,
    RestartPolicy,
    register_multiprocess_nodes,
    shutdown_multiprocess_nodes,
)
from support.processes import parent_of, state_of
from support.program import Program, running
from support.stopwatch import Stopwatch
from support.waiting import wait_until

APP = """
import os, time
from rosbase import BaseHandlers, BaseManager, BaseNode, RestartPolicy, register_multiprocess_nodes
from rosbase.processes import judge

class Node(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.logger.info(f"on {os.getpid()}")

class App(BaseManager):
    def release_resources(self):
        print("released", flush=True)

class Handlers(BaseHandlers):
    is_up = False
    def handle(self):
        if not self.is_up and all(child.pid for child in processes.values()):
            self.is_up = True
            print("running", *(child.pid for child in processes.values()), flush=True)

# It is half a second, which passes on a machine that stalls between two signals.
judge._HESITATION_NS = 5_000_000_000

if __name__ == "__main__":
    processes = register_multiprocess_nodes(
        NODES, COMMANDS, restart=RestartPolicy("always", first_delay_s=0.01)
    )
    App(handlers_class=Handlers).start_main_loop_timer(processes)
    print("returned", [child.is_alive for child in processes.values()])
"""
WAIT = "while :; do sleep 0.01; done"
COMMAND = {"x": "echo on; exec sleep 500"}


def app(commands: dict[str, str], nodes: str = "{}") -> str:
    return APP.replace("COMMANDS", repr(commands)).replace("NODES", nodes)


def read_pids(program: Program) -> list[int]:
    """Waits until all children run; their process numbers."""
    assert program.process.stdout is not None
    return [int(word) for word in program.process.stdout.readline().split()[1:]]


def read_err_until(program: Program, text: str) -> str:
    """Waits for a line with this text on stderr; what was written there up to it."""
    assert program.process.stderr is not None
    said = ""
    while text not in said:
        line = program.process.stderr.readline()
        assert line, f"it ended without {text!r}: {said}"
        said += line
    return said


def whole_group(program: Program) -> list[int]:
    """Everybody: the manager last, as far as one can choose."""
    return sorted(program.family(), reverse=True)


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("gap_s", [0.0, 0.1, 0.4])
def test_a_child_that_is_stopped_just_before_its_manager_is_not_started_again(
    tmp_path: Path, signum: int, gap_s: float
) -> None:
    with running(tmp_path, app(COMMAND)) as program:
        (child,) = read_pids(program)
        said = read_err_until(program, "x: on")
        os.kill(child, signum)
        # Not to wait for something: this is what happens.
        time.sleep(gap_s)
        program.process.send_signal(signum)
        status, out, err = program.end()
    assert (status, out) == (0, "released\nreturned [False]\n"), err
    assert "x: on" not in err, "it was said before"
    assert "again" not in said + err
    assert "ERROR" not in err
    name = signal.Signals(signum).name
    assert f"[INFO] [BaseManager]: x: was ended by {name}" in err


@pytest.mark.parametrize(
    ("commands", "nodes"),
    [
        (COMMAND, "{}"),
        ({"x": f"echo on; trap 'exit 0' TERM; {WAIT}"}, "{}"),
        ({"x": "echo on; sleep 500 | sleep 500"}, "{}"),
        ({"x": "echo on; setsid sleep 500 & wait"}, "{}"),
        ({}, "{'x': Node}"),
        ({"y": "sleep 500"}, "{'x': Node}"),
    ],
)
def test_a_signal_to_the_whole_group_as_systemd_sends_it_ends_all_in_order(
    tmp_path: Path, commands: dict[str, str], nodes: str
) -> None:
    with running(tmp_path, app(commands, nodes)) as program:
        read_pids(program)
        for pid in whole_group(program):
            try:
                os.kill(pid, signal.SIGTERM)
            except ProcessLookupError:
                # A signal to another one has ended it.
                continue
        status, out, err = program.end()
        assert not program.family()
    assert status == 0, err
    assert out.startswith("released\nreturned [False")
    assert "again" not in err


def test_a_node_that_is_stopped_just_before_its_manager_is_not_started_again(
    tmp_path: Path,
) -> None:
    with running(tmp_path, app({}, "{'x': Node}")) as program:
        (child,) = read_pids(program)
        os.kill(child, signal.SIGTERM)
        wait_until(lambda: state_of(child) == "", "the end of the node")
        program.process.send_signal(signal.SIGTERM)
        status, out, err = program.end()
    assert (status, out) == (0, "released\nreturned [False]\n"), err
    assert "again" not in err


def test_a_guardian_that_is_told_to_stop_stops_its_child_and_waits_for_the_manager(
    tmp_path: Path,
) -> None:
    with running(
        tmp_path, app({"x": "trap 'exit 5' INT; while :; do sleep 0.01; done"})
    ) as program:
        (child,) = read_pids(program)
        os.kill(parent_of(child), signal.SIGTERM)
        wait_until(lambda: state_of(child) == "", "the end of the child")
        program.process.send_signal(signal.SIGTERM)
        status, _, err = program.end()
    assert status == 0
    assert "again" not in err
    assert "[INFO] [BaseManager]: x: ended with status 5" in err


def test_a_required_child_that_fails_when_it_is_stopped_with_its_manager_does_not_give_its_status(
    tmp_path: Path,
) -> None:
    ready = tmp_path / "ready"
    command = f"trap 'exit 3' TERM; touch {ready}; {WAIT}"
    policy = 'restart=RestartPolicy("always", first_delay_s=0.01)'
    source = app({"x": command}).replace(policy, "required=True")
    with running(tmp_path, source) as program:
        (child,) = read_pids(program)
        wait_until(ready.exists, "its trap")
        os.kill(child, signal.SIGTERM)
        wait_until(lambda: state_of(child) == "", "the end of the child")
        program.process.send_signal(signal.SIGTERM)
        status, out, _ = program.end()
    assert (status, out) == (0, "released\nreturned [False]\n")


class UntilTold(BaseHandlers):
    """Stops the manager when a test says so."""

    is_over: Callable[[], bool]

    def handle(self) -> None:
        if type(self).is_over():
            self.manager.request_stop()


def test_a_child_that_is_stopped_alone_is_judged_half_a_second_later(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    processes = register_multiprocess_nodes(
        {}, COMMAND, restart=RestartPolicy("always", first_delay_s=0.0)
    )
    killed: list[float] = []

    class Handlers(UntilTold):
        @staticmethod
        def is_over() -> bool:
            if not killed and "x: on" in caplog.messages and processes["x"].pid:
                os.kill(processes["x"].pid, signal.SIGTERM)
                killed.append(time.monotonic())
            return caplog.messages.count("x: on") == 2

    BaseManager(handlers_class=Handlers).start_main_loop_timer(processes)
    assert time.monotonic() - killed[0] > 0.5
    errors = [r.getMessage() for r in caplog.records if r.levelname == "ERROR"]
    assert errors == ["x: was ended by SIGTERM"]


@pytest.mark.parametrize("how", ["exit 1", "kill -KILL $$", "exit 143 | exit 4"])
def test_an_end_that_is_no_stop_is_judged_at_once(
    how: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    policy = RestartPolicy("always", limit=3, first_delay_s=0.0)
    with Stopwatch() as watch:
        processes = register_multiprocess_nodes({}, {"x": how}, restart=policy)
        wait_until(lambda: "x: not started again: 3 in a row" in caplog.messages, "four ends")
        took_s = watch.took_s
    shutdown_multiprocess_nodes(processes)
    assert took_s < 2.0


def test_nothing_follows_from_an_end_once_a_stop_has_been_asked_for(
    caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    caplog.set_level("INFO", logger="rosbase")
    gate = tmp_path / "gate"
    os.mkfifo(gate)
    processes = register_multiprocess_nodes(
        {},
        {"x": f"echo up; read line < {gate}; exit 4"},
        restart=RestartPolicy("always", first_delay_s=0.0),
        required=True,
    )
    wait_until(lambda: "x: up" in caplog.messages, "its start")
    processes.stopping_soon()
    processes.stopping_soon()
    gate.write_text("go\n")
    wait_until(lambda: not processes["x"].is_alive, "its end")
    wait_until(lambda: "x: ended with status 4" in caplog.messages, "the news of it")
    shutdown_multiprocess_nodes(processes)
    processes.stopping_soon()
    assert [r.levelname for r in caplog.records if "status 4" in r.getMessage()] == ["INFO"]
    assert "again" not in caplog.text
    assert processes.exit_status == 0


@pytest.mark.parametrize("ends", ["a stop that is asked for", "an exception"])
def test_a_child_that_ends_while_lifecycle_nodes_are_taken_down_is_not_started_again(
    tmp_path: Path, ends: str
) -> None:
    source = """
    import os, signal, sys, time
    from rosbase import *
    from rosbase.lifecycle import CallbackReturn

    class Slow(LifecycleNode):
        def on_deactivate(self, state):
            os.kill(processes["x"].pid, signal.SIGKILL)
            time.sleep(1.5)
            return CallbackReturn.SUCCESS

    class Handlers(BaseHandlers):
        def handle(self):
            if processes["x"].pid:
                if sys.argv[1] == "an exception":
                    raise ValueError("what ended it")
                self.manager.request_stop()

    if __name__ == "__main__":
        policy = RestartPolicy("always", first_delay_s=0.01)
        processes = register_multiprocess_nodes(
            {}, {"x": "echo on; exec sleep 500"}, restart=policy
        )
        manager = BaseManager(nodes_dict={"slow": Slow}, handlers_class=Handlers)
        manager.nodes["slow"].trigger_configure()
        manager.nodes["slow"].trigger_activate()
        manager.start_main_loop_timer(processes)
    """
    with running(tmp_path, source, ends) as program:
        status, _, err = program.end()
    assert status == (1 if ends == "an exception" else 0)
    assert "again" not in err


def test_a_guardian_that_is_stopped_does_not_hold_up_the_end(tmp_path: Path) -> None:
    trap = "trap 'echo bye; exit 0' INT"
    commands = {name: f"{trap}; touch {tmp_path / name}; {WAIT}" for name in "abc"}
    with running(tmp_path, app(commands)) as program:
        children = read_pids(program)
        wait_until(lambda: all((tmp_path / name).exists() for name in "abc"), "their traps")
        for child in children:
            os.kill(parent_of(child), signal.SIGSTOP)
            wait_until(lambda c=child: state_of(parent_of(c)) == "T", "its rest")  # type: ignore[misc]  # mypy infers no default of a lambda
        took_s, status, _, err = program.stop(signal.SIGTERM)
        assert took_s < 2.0
        assert not program.family()
    assert status == 0
    assert err.count("bye") == 3, "each had its proper end"


def test_a_guardian_that_is_stopped_again_and_again_is_ended_with_all_that_it_guards(
    tmp_path: Path,
) -> None:
    with running(tmp_path, app(COMMAND)) as program:
        (child,) = read_pids(program)
        guardian = parent_of(child)
        asked = time.monotonic()
        program.process.send_signal(signal.SIGTERM)
        while state_of(guardian):
            try:
                os.kill(guardian, signal.SIGSTOP)
            except ProcessLookupError:
                break
            assert time.monotonic() - asked < 10.0
        status, _, _ = program.end()
        assert not program.family()
    assert status == 0


def test_a_guardian_that_is_stopped_when_its_manager_is_killed_goes_on_and_clears_away(
    tmp_path: Path,
) -> None:
    with running(tmp_path, app(COMMAND)) as program:
        (child,) = read_pids(program)
        os.kill(parent_of(child), signal.SIGSTOP)
        wait_until(lambda: state_of(parent_of(child)) == "T", "its rest")
        with Stopwatch() as watch:
            program.process.kill()
            wait_until(lambda: not program.family(), "the end of all")
            assert watch.took_s < 3.0
