"""Nothing that a manager started outlives it, however it ends."""

import signal
from pathlib import Path

import pytest

from support.program import running
from support.stopwatch import Stopwatch
from support.waiting import wait_until

APP = """
import os, subprocess, sys, time
from rosbase import (BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes,
                     shutdown_multiprocess_nodes)
from rosbase.messages import Header

class Talker(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        publisher = self.create_publisher(Header, "alive", 10)
        self.create_timer(0.01, lambda: publisher.publish(Header()))

class Listener(BaseNode):
    heard = 0
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_subscription(Header, "alive", self.hear, 10)
    def hear(self, message):
        self.heard += 1

class App(BaseManager):
    def release_resources(self):
        print("released", flush=True)

if __name__ == "__main__":
    processes = register_multiprocess_nodes({"talker": Talker}, {
        "background": "sleep 1000 &",
        "pipeline": "sleep 1000 | cat",
        "leaver": "setsid sleep 1000 & sleep 1000",
        "deaf": "trap '' INT TERM; while true; do sleep 1000; done",
    })
    class Handlers(BaseHandlers):
        def handle(self):
            if self.timestamp == 0:
                print("running", flush=True)
    BODY
"""
RUN = """app = App(nodes_dict={"listener": Listener}, handlers_class=Handlers)
    app.add_handshake_rule("a child's topic", lambda: app.nodes["listener"].heard > 3)
    app.add_handshake_rule("all children", lambda: all(c.pid for c in processes.values()))
    app.start_main_loop_timer(processes)
    print("returned", {name: child.exit_code for name, child in processes.items()})
"""
SLEEPERS = 5


def count(family: dict[int, str], command: str) -> int:
    return sum(text.strip() == command for text in family.values())


def test_after_sigkill_of_the_manager_nothing_is_alive_two_seconds_later(tmp_path: Path) -> None:
    with running(tmp_path, APP.replace("BODY", RUN)) as program:
        program.read_until("running")
        wait_until(lambda: count(program.family(), "sleep 1000") == SLEEPERS, "all commands")
        with Stopwatch() as watch:
            program.process.send_signal(signal.SIGKILL)
            wait_until(lambda: not program.family(), "the end of all processes")
            assert watch.took_s < 2.0


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_all_children_with_status_0_and_no_traceback(
    tmp_path: Path, signum: int
) -> None:
    with running(tmp_path, APP.replace("BODY", RUN)) as program:
        program.read_until("running")
        took_s, status, out, err = program.stop(signum)
        assert took_s < 6.0, "the waits are bounded"
        assert not program.family()
        assert status == 0
        assert "Traceback" not in err
        assert out.startswith("released\nreturned {'talker': 0, 'background': -15,")


def test_children_are_stopped_before_the_programs_own_resources_are_released(
    tmp_path: Path,
) -> None:
    look = RUN.replace("app = App", "App.release_resources = look\n    app = App")
    app = APP.replace(
        "BODY", "def look(self): print(sorted(processes.values(), key=str))\n    BODY"
    )
    with running(tmp_path, app.replace("BODY", look)) as program:
        program.read_until("running")
        program.process.send_signal(signal.SIGINT)
        _, out, _ = program.end()
        assert "pid" not in out.splitlines()[0]


@pytest.mark.parametrize(
    "body",
    [
        pytest.param("raise SystemExit(3)", id="the program ends without running a manager"),
        pytest.param(
            "App(nodes_dict={'bad': lambda manager: 1 / 0})", id="building the manager raises"
        ),
        pytest.param("App(backend='no such thing')", id="the manager gets no backend"),
    ],
)
def test_children_do_not_leak_if(tmp_path: Path, body: str) -> None:
    with running(tmp_path, APP.replace("BODY", body)) as program:
        assert program.end()[0] != 0
        assert not program.family()


def test_a_manager_that_cannot_be_built_stops_the_children_at_once(tmp_path: Path) -> None:
    body = """
    try:
        App(nodes_dict={"bad": lambda manager: 1 / 0})
    except ZeroDivisionError:
        print([child.is_alive for child in processes.values()])
    """
    with running(tmp_path, APP.replace("BODY", body)) as program:
        status, out, err = program.end()
        assert (status, out) == (0, "[False, False, False, False, False]\n"), err


def test_ctrl_c_in_a_terminal_reaches_a_child_once_through_its_manager(tmp_path: Path) -> None:
    app = """
    import os
    from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
    if __name__ == "__main__":
        processes = register_multiprocess_nodes({}, {"child": "ps -o sid= -p $$; sleep 1000"})
        while processes["child"].pid is None:
            pass
        print(os.getsid(processes["child"].pid) == processes["child"].pid)
        shutdown_multiprocess_nodes(processes)
        shutdown_multiprocess_nodes(processes)
    """
    with running(tmp_path, app) as program:
        status, out, _ = program.end()
        assert (status, out) == (0, "True\n")


def test_a_program_without_a_main_guard_is_told_so_and_starts_no_more(tmp_path: Path) -> None:
    app = """
    import time
    from rosbase import BaseNode, register_multiprocess_nodes
    class Node(BaseNode): ...
    processes = register_multiprocess_nodes({"node": Node}, {})
    while processes["node"].is_alive:
        time.sleep(0.01)
    print(processes["node"].exit_code)
    """
    with running(tmp_path, app) as program:
        status, out, err = program.end()
        assert (status, out) == (0, "1\n")
        assert "if __name__ == '__main__':" in err


def test_the_children_of_a_manager_that_stops_itself_do_not_keep_it_waiting(
    tmp_path: Path,
) -> None:
    app = """
    import time
    from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
    if __name__ == "__main__":
        # Shells have what they put into the background ignore SIGINT.
        processes = register_multiprocess_nodes(None, {"a": "sleep 1000 &", "b": "sleep 1000 &"})
        while not all(child.pid for child in processes.values()):
            time.sleep(0.01)
        time.sleep(0.2)
        start = time.monotonic()
        shutdown_multiprocess_nodes(processes)
        # Who waited for SIGINT to end them would wait for two seconds.
        print(time.monotonic() - start < 1.9)
    """
    with running(tmp_path, app) as program:
        status, out, err = program.end()
        assert (status, out) == (0, "True\n"), err
