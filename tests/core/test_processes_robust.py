"""What happens between a manager and its children when things go wrong in odd ways."""

import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from rosbase import RestartPolicy, register_multiprocess_nodes, shutdown_multiprocess_nodes
from rosbase.logger import RosbaseLogger
from rosbase.processes import guardian
from rosbase.processes.child import ChildProcess, Life
from rosbase.processes.launch import CommandLaunch, Launch, Launched, Order
from rosbase.processes.supervisor import Supervisor
from support.program import running
from support.stopwatch import Stopwatch
from support.waiting import wait_until


def test_the_end_of_the_output_may_come_before_the_last_words() -> None:
    child = ChildProcess("x", CommandLaunch("exit 3"), RestartPolicy())
    supervisor = Supervisor([], RosbaseLogger("test"))
    supervisor._start(child)
    (life,) = supervisor._lives
    process = life._guardian
    assert isinstance(process, subprocess.Popen)
    wait_until(lambda: process.poll() is not None, "the end of the guardian")
    while supervisor._read(life):
        pass
    supervisor._end(life)
    assert child.exit_code == 3
    supervisor.start()
    supervisor.stop()


def test_a_failure_before_a_stop_is_an_error_even_if_the_stop_comes_before_its_line(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    child = ChildProcess("x", CommandLaunch("exit 3"), RestartPolicy())
    supervisor = Supervisor([child], RosbaseLogger("test"))
    hear = Life.hear

    def hear_and_stop(life: Life) -> bool:
        goes_on = hear(life)
        if child.exit_code is not None:
            # Like a thread that waits for the exit code, and runs at this moment.
            supervisor.stopping_soon()
        return goes_on

    monkeypatch.setattr(Life, "hear", hear_and_stop)
    supervisor.start()
    wait_until(lambda: not child.is_alive, "the end of the child")
    supervisor.stop()
    assert [(record.levelname, record.message) for record in caplog.records] == [
        ("ERROR", "x: ended with status 3")
    ]


def test_a_child_that_cannot_be_started_again_does_not_harm_the_others(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class OnlyOnce(Launch):
        def __init__(self) -> None:
            self.starts = 0

        def start(self, order: Order) -> Launched:
            self.starts += 1
            if self.starts > 1:
                raise RuntimeError("gone")
            return CommandLaunch("exit 1").start(order)

    policy = RestartPolicy("always", limit=3, first_delay_s=0.01)
    once = ChildProcess("once", OnlyOnce(), policy)
    other = ChildProcess("other", CommandLaunch("sleep 1000"), RestartPolicy())
    supervisor = Supervisor([once, other], RosbaseLogger("test"))
    supervisor.start()
    wait_until(lambda: "once: not started again: 3 in a row" in caplog.messages, "three tries")
    assert "once: cannot be started: gone" in caplog.messages
    assert other.is_alive
    supervisor.stop()
    assert not other.is_alive


def test_a_handler_that_fails_ends_its_own_child_only(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    processes = register_multiprocess_nodes(
        {}, {"bad": "sleep 0.2; echo x; sleep 1000", "good": "sleep 1000"}
    )
    monkeypatch.setattr(
        "rosbase.processes.output.OutputLines.feed", lambda *_: (_ for _ in ()).throw(KeyError("k"))
    )
    wait_until(lambda: not processes["bad"].is_alive, "the end of the bad one")
    assert "bad: KeyError('k')" in caplog.messages
    assert processes["good"].is_alive
    shutdown_multiprocess_nodes(processes)
    assert not processes["good"].is_alive


def test_the_end_is_noticed_though_somebody_holds_on_to_the_connections(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    held: list[int] = []
    socketpair = socket.socketpair

    def pair_that_is_held() -> tuple[socket.socket, socket.socket]:
        ends = socketpair()
        # As a worker does that was forked at this moment.
        held.append(os.dup(ends[1].fileno()))
        return ends

    monkeypatch.setattr(socket, "socketpair", pair_that_is_held)
    processes = register_multiprocess_nodes({}, {"x": "true", "y": "sleep 1000"})
    wait_until(lambda: not processes["x"].is_alive, "the end of x")
    with Stopwatch() as watch:
        shutdown_multiprocess_nodes(processes)
        assert watch.took_s < 3.0
    assert [child.is_alive for child in processes.values()] == [False, False]
    for fd in held:
        os.close(fd)


def test_shutdown_is_harmless_from_several_threads() -> None:
    processes = register_multiprocess_nodes({}, {"x": "sleep 1000", "y": "sleep 1000 &"})
    errors: list[BaseException] = []

    def stop() -> None:
        try:
            shutdown_multiprocess_nodes(processes)
            assert not processes["x"].is_alive
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=stop) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert errors == []


def test_shutdown_that_was_interrupted_can_be_done_again(tmp_path: Path) -> None:
    app = """
    import _thread, pathlib, sys, threading, time
    from rosbase import register_multiprocess_nodes, shutdown_multiprocess_nodes
    if __name__ == "__main__":
        trapped = pathlib.Path(sys.argv[0]).with_name("trapped")
        command = f"trap : INT; touch {trapped}; while :; do sleep 0.1; done"
        processes = register_multiprocess_nodes({}, {"x": command})
        while not trapped.exists():
            time.sleep(0.01)
        timer = threading.Timer(0.2, _thread.interrupt_main)
        timer.start()
        try:
            shutdown_multiprocess_nodes(processes)
        except KeyboardInterrupt:
            print("interrupted")
        shutdown_multiprocess_nodes(processes)
        print(processes["x"].is_alive)
    """
    with running(tmp_path, app) as program:
        assert program.end()[:2] == (0, "interrupted\nFalse\n")
        assert not program.family()


def test_nothing_is_left_though_the_manager_is_killed_at_once_and_had_forked(
    tmp_path: Path,
) -> None:
    app = """
    import os, time
    from rosbase import register_multiprocess_nodes
    if __name__ == "__main__":
        register_multiprocess_nodes({}, {"a": "sleep 1000 & sleep 1000"})
        if os.fork() == 0:
            # A worker that inherits every descriptor, and lives on.
            os.close(1)
            os.close(2)
            time.sleep(15)
            os._exit(0)
        os.kill(os.getpid(), 9)
    """
    with running(tmp_path, app) as program:
        program.end()
        with Stopwatch() as watch:
            wait_until(lambda: len(program.family()) <= 1, "the end of all but the worker")
            assert watch.took_s < 2.0


def test_a_manager_that_blocks_signals_still_sees_ends(tmp_path: Path) -> None:
    app = """
    import signal, time
    from rosbase import register_multiprocess_nodes
    if __name__ == "__main__":
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGCHLD, signal.SIGINT, signal.SIGTERM})
        processes = register_multiprocess_nodes({}, {"x": "grep SigBlk /proc/self/status"})
        while processes["x"].is_alive:
            time.sleep(0.01)
        print(processes["x"].exit_code)
    """
    with running(tmp_path, app) as program:
        status, out, err = program.end()
        assert (status, out) == (0, "0\n")
        assert "SigBlk: 0000000000000000" in err


def test_a_long_command_line_and_the_programs_start_method_are_no_trouble(tmp_path: Path) -> None:
    app = """
    import multiprocessing, sys, time
    from rosbase import BaseNode, register_multiprocess_nodes, shutdown_multiprocess_nodes

    class Node(BaseNode):
        def __init__(self):
            super().__init__()
            print("argv", len(sys.argv[1]), multiprocessing.get_start_method(allow_none=True))
            self.create_timer(0.01, self._request_stop)

    if __name__ == "__main__":
        sys.argv.append("x" * 1_000_000)
        processes = register_multiprocess_nodes({"node": Node}, {})
        multiprocessing.set_start_method("fork")
        while processes["node"].is_alive:
            time.sleep(0.01)
        shutdown_multiprocess_nodes(processes)
        print(processes["node"].exit_code)
    """
    with running(tmp_path, app) as program:
        status, out, err = program.end()
        assert (status, out) == (0, "0\n"), err
        assert "node: argv 1000000 None" in err


def test_a_command_that_is_stopped_while_it_starts_ends_at_the_first_signal() -> None:
    ours, theirs = socket.socketpair()
    # It will find this as soon as it has forked.
    ours.send(b"s")
    argv = [sys.executable, "-I", "-S", guardian.__file__, str(theirs.fileno()), str(os.getpid())]
    with (
        ours,
        subprocess.Popen(
            [*argv, "-1", "/bin/sh", "-c", "exec sleep 1000"],
            pass_fds=[theirs.fileno()],
            start_new_session=True,
        ),
    ):
        theirs.close()
        said = b"".join(iter(lambda: ours.recv(4096), b"")).decode().split()
    assert said[0] == "started"
    assert said[2:] == ["ended", said[1], str(-signal.SIGINT)]


def test_a_hundred_children_come_and_go() -> None:
    processes = register_multiprocess_nodes({}, {f"c{n}": "sleep 1000 &" for n in range(100)})
    shutdown_multiprocess_nodes(processes)
    assert not any(child.is_alive for child in processes.values())


def test_a_manager_runs_where_there_are_no_posix_signals_and_children_are_refused(
    tmp_path: Path,
) -> None:
    app = """
    import os, signal
    for name in ("SIGHUP", "SIGKILL", "SIGPIPE", "SIGXFSZ", "SIGCHLD", "pthread_sigmask"):
        delattr(signal, name)
    from rosbase import BaseHandlers, BaseManager, register_multiprocess_nodes
    from rosbase.errors import ConfigurationError

    class Handlers(BaseHandlers):
        def handle(self):
            self.manager.request_stop()

    manager = BaseManager(handlers_class=Handlers)
    manager.start_main_loop_timer()
    os.name = "nt"
    try:
        register_multiprocess_nodes({}, {"x": "true"})
    except ConfigurationError as refusal:
        print(manager.timestamp, refusal)
    os.name = "posix"
    """
    with running(tmp_path, app) as program:
        assert program.end() == (0, "1 child processes need a POSIX system\n", "")
