"""Children without which the program is not to go on."""

import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from rosbase import BaseManager, BaseNode, register_multiprocess_nodes
from rosbase.errors import ConfigurationError
from support.blocking_program import BLOCKING_PROGRAM
from support.program import running

APP = """
import os, sys, time
from rosbase import (BaseHandlers, BaseManager, BaseNode, LifecycleNode, RestartPolicy,
                     register_multiprocess_nodes)
from rosbase.lifecycle import CallbackReturn

class Node(BaseNode):
    pass

class Broken(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        raise ValueError("no lens")

class Failing(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_timer(0.05, self.fail)
    def fail(self):
        raise ValueError("lens cap is on")

class Leaving(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_timer(0.05, self._request_stop)

class Exiting(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        sys.exit(44)

class Device(LifecycleNode):
    def on_shutdown(self, state):
        print("shut down", flush=True)
        return CallbackReturn.SUCCESS

class App(BaseManager):
    def release_resources(self):
        print("released", flush=True)

class Handlers(BaseHandlers):
    def handle(self):
        if self.timestamp > 600 or os.path.exists("stop"):
            self.manager.request_stop()

if __name__ == "__main__":
    processes = register_multiprocess_nodes(OPTIONS)
    app = App(nodes_dict={"device": Device}, handlers_class=Handlers)
    RULES
    app.start_main_loop_timer(processes)
    print("returned", app.timestamp > 600)
"""
CLEAN_UP = "shut down\nreleased\n"


def run(folder: Path, options: str, rules: str = "pass") -> tuple[int, str, str]:
    source = APP.replace("OPTIONS", options).replace("RULES", rules)
    with running(folder, source) as program:
        ended = program.end()
        assert not program.family()
    return ended


@pytest.mark.parametrize(
    ("nodes", "commands", "status", "why"),
    [
        ("{'x': Broken}", "{}", 1, "x: ended with status 1"),
        ("{'x': Failing}", "{}", 1, "x: ended with status 1"),
        ("{'x': Exiting}", "{}", 44, "x: ended with status 44"),
        ("{}", "{'x': 'sleep 0.2; exit 3'}", 3, "x: ended with status 3"),
        ("{}", "{'x': 'kill -SEGV $$'}", 128 + signal.SIGSEGV, "x: was ended by SIGSEGV"),
        ("{}", "{'x': 'sleep 0.1; kill $$'}", 128 + signal.SIGTERM, "x: was ended by SIGTERM"),
        ("{}", "{'x': '/no/such/program'}", 127, "x: ended with status 127"),
        ("{}", "{'x': '(sleep 0.1; exit 4) &'}", 4, "x: ended with status 4"),
    ],
)
def test_when_a_required_child_ends_the_program_ends_in_order_with_its_status(
    tmp_path: Path, nodes: str, commands: str, status: int, why: str
) -> None:
    others = commands.replace("{", "{'other': 'sleep 1000', ")
    ended, out, err = run(tmp_path, f"{nodes}, {others}, required=['x']")
    assert (ended, out) == (status, CLEAN_UP), err
    assert f"[ERROR] [App]: {why}" in err.replace("[processes]", "[App]").replace(
        "[BaseManager]", "[App]"
    )
    assert "x: is required, so the program ends" in err
    assert "other: was ended by SIGINT" in err
    assert "SystemExit" not in err


@pytest.mark.parametrize(
    "options", ["{'x': Leaving}, {}, required=True", "{}, {'x': 'sleep 0.1'}, required='x'"]
)
def test_a_required_child_that_ends_well_ends_the_program_well(
    tmp_path: Path, options: str
) -> None:
    status, out, err = run(tmp_path, options)
    assert (status, out) == (0, CLEAN_UP + "returned False\n"), err
    assert "x: is required, so the program ends" in err


def test_a_required_child_may_be_started_again_before_it_has_ended_for_good(
    tmp_path: Path,
) -> None:
    options = (
        "{}, {'x': 'echo up; exit 6'}, required={'x': True},"
        " restart=RestartPolicy('on-failure', limit=2, first_delay_s=0.01)"
    )
    status, out, err = run(tmp_path, options)
    assert (status, out) == (6, CLEAN_UP), err
    assert err.count("x: up") == 3
    assert "x: not started again: 2 in a row" in err


def test_a_required_child_that_has_ended_before_there_is_a_manager_counts_too(
    tmp_path: Path,
) -> None:
    rules = "while processes.exit_status == 0: time.sleep(0.01)"
    status, out, err = run(tmp_path, "{}, {'x': 'exit 7'}, required=True", rules)
    assert (status, out) == (7, CLEAN_UP), err


def test_a_required_child_that_ends_during_the_handshake_ends_it(tmp_path: Path) -> None:
    rules = "app.add_handshake_rule('a camera', lambda: False)"
    status, out, err = run(tmp_path, "{'x': Broken}, {}, required=True", rules)
    assert (status, out) == (1, CLEAN_UP), err
    assert "ValueError: no lens" in err


@pytest.mark.parametrize(
    "place",
    [
        *("handle", "handshake", "callback", "on_configure", "loop in handle", "recv in handle"),
        *("spin in handle", "spin in handshake", "stubborn in handle", "input in handle"),
    ],
)
def test_the_end_of_a_required_child_ends_code_that_blocks(place: str, tmp_path: Path) -> None:
    command = f"while [ ! -e {tmp_path}/go ]; do sleep 0.02; done; exit 5"
    source = (
        "from rosbase import register_multiprocess_nodes\n"
        f"processes = register_multiprocess_nodes({{}}, {{'x': '{command}'}}, required=True)\n"
        + BLOCKING_PROGRAM
    )
    main, terminal = os.openpty()
    with running(tmp_path, source, place, stdin=terminal) as program:
        program.read_until("blocking")
        (tmp_path / "go").touch()
        since = time.monotonic()
        status, out, err = program.end()
        took_s = time.monotonic() - since
    os.close(main)
    os.close(terminal)
    # Half a second in which the whole program may be asked to stop, and half of patience.
    assert took_s < 5.0
    assert (status, err.count("Traceback")) == (5, 0), err
    assert out.replace("name? ", "").splitlines()[-2:] == ["arm shut down", "released"]
    assert "x: is required, so the program ends" in err


def test_the_first_required_child_that_ends_gives_the_status(tmp_path: Path) -> None:
    commands = "{'a': 'sleep 0.2; exit 5', 'b': 'trap \"exit 6\" INT; while :; do sleep 0.1; done'}"
    status, _, err = run(tmp_path, f"{{}}, {commands}, required=True")
    assert status == 5, err


@pytest.mark.parametrize("options", ["", "required=False", "required=[]", "required={'x': False}"])
def test_a_child_that_is_not_required_may_end_and_the_program_goes_on(
    tmp_path: Path, options: str
) -> None:
    (tmp_path / "stop").touch()
    rules = "os.chdir(sys.argv[0].rpartition('/')[0])"
    rules += "; [time.sleep(0.01) for _ in iter(lambda: processes['x'].is_alive, False)]"
    status, out, err = run(tmp_path, f"{{'x': Broken}}, {{}}, {options}", rules)
    assert (status, out) == (0, CLEAN_UP + "returned False\n"), err
    assert "is required" not in err


def test_a_constructor_that_raises_in_a_process_of_its_own_is_an_error_with_its_traceback(
    tmp_path: Path,
) -> None:
    (tmp_path / "stop").touch()
    rules = "os.chdir(sys.argv[0].rpartition('/')[0])"
    rules += "; [time.sleep(0.01) for _ in iter(lambda: processes['x'].is_alive, False)]"
    _, _, err = run(tmp_path, "{'x': Broken}, {}", rules)
    lines = [line.partition(" ")[::2] for line in err.splitlines()]
    traceback = [text.partition(": x: ")[2] for level, text in lines if level == "[ERROR]"]
    assert traceback[0] == "Traceback (most recent call last):"
    assert '    raise ValueError("no lens")' in traceback
    assert traceback[-2:] == ["ValueError: no lens", "ended with status 1"]


def test_a_clean_up_that_fails_counts_more_than_the_status_of_a_child(tmp_path: Path) -> None:
    rules = "app.release_resources = lambda: 1 / 0"
    status, _, err = run(tmp_path, "{}, {'x': 'exit 7'}, required=True", rules)
    assert status == 1
    assert "ZeroDivisionError" in err


def test_whoever_catches_the_end_finds_the_status(caplog: pytest.LogCaptureFixture) -> None:
    processes = register_multiprocess_nodes({}, {"x": "exit 9"}, required=True)
    with pytest.raises(SystemExit) as end:
        BaseManager().start_main_loop_timer(processes)
    assert end.value.code == processes.exit_status == 9
    assert processes["x"].exit_code == 9


@pytest.mark.parametrize("option", ["required", "pty"])
@pytest.mark.parametrize("names", [["b"], "b", {"b": True}, {"x", "b"}])
def test_a_name_that_no_child_has_is_refused(option: str, names: Any) -> None:
    with pytest.raises(ConfigurationError, match=f"{option}: no child is called b"):
        register_multiprocess_nodes({"x": BaseNode}, {}, **{option: names})
