"""Programs that use rclpy themselves: its default context and the manager end together."""

import signal
from pathlib import Path

import pytest

from support.program import Program, running

HOST = """
import warnings
# rclpy imports a parser that imports what Python has deprecated.
warnings.simplefilter("ignore", DeprecationWarning)
import sys, threading, time
import rclpy
from rosbase import BaseHandlers, BaseManager, BaseNode
from rosbase.messages import String

PLACE = sys.argv[1]
is_looping = threading.Event()


def loop():
    if threading.current_thread() is threading.main_thread():
        is_looping.set()
    while rclpy.ok():
        time.sleep(0.02)
    print("host ends", flush=True)


def block_in(place):
    if PLACE == place:
        print("running", flush=True)
        time.sleep(100)


class Talker(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        if "lent" in PLACE:
            # It has called no `rclpy.init()`.
            host.start()
        if PLACE == "init in constructor":
            rclpy.init()
            host.start()
        self.publisher = self.create_publisher(String, "talk", 1)
        self.create_timer(0.005, lambda: self.publisher.publish(String("hello")))
        block_in("constructor")

    def release_resources(self):
        print("talker released", flush=True)


class Handlers(BaseHandlers):
    def handle(self):
        if self.timestamp == 0:
            if PLACE.startswith("init in handle"):
                rclpy.init()
                host.start()
            if PLACE == "on a thread":
                # The signal must not come before the main thread is in its loop.
                is_looping.wait()
            print("running", flush=True)
        if PLACE == "loop in handle":
            loop()
        if self.timestamp == 10:
            if PLACE in ("shutdown", "shutdown, lent", "init in handle, shutdown"):
                rclpy.shutdown()
            if PLACE == "try_shutdown":
                rclpy.try_shutdown()
            if PLACE == "shutdown of all":
                rclpy.get_default_context().shutdown()
                self.manager.backend.node.context.shutdown()
            if PLACE == "shutdown of the node's":
                rclpy.shutdown(context=self.manager.backend.node.context)
            if PLACE == "stop":
                self.manager.request_stop()
            if PLACE == "raise":
                raise ValueError("no cup")


class App(BaseManager):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        block_in("own constructor")

    def handshake(self):
        if PLACE == "loop in handshake":
            print("running", flush=True)
            while rclpy.ok():
                self.backend.spin_once(0.1)
        return super().handshake()

    def release_resources(self):
        # As old programs wait for their threads.
        if threading.current_thread() is threading.main_thread() and PLACE not in ENDS_LATE:
            host.join()
        print("released", rclpy.ok(), flush=True)


ENDS_LATE = ("stop", "raise", "shutdown of the node's")
host = threading.Thread(target=loop)
if not (PLACE.startswith("init") or "lent" in PLACE):
    rclpy.init()
    host.start()
if PLACE == "lone node":
    class Lone(Talker):
        def __init__(self):
            super().__init__()
            self.create_timer(0.02, self.say)
            self.was_said = False

        def say(self):
            if not self.was_said:
                self.was_said = True
                print("running", flush=True)

        def release_resources(self):
            host.join()
            print("released", rclpy.ok(), flush=True)

    Lone().start_spin_standalone()
else:
    manager = App(nodes_dict={"talker": Talker}, handlers_class=Handlers)
    if PLACE == "on a thread":
        thread = threading.Thread(target=manager.start_main_loop_timer)
        thread.start()
        loop()
        thread.join()
    else:
        manager.start_main_loop_timer()
print("returned", rclpy.ok(), flush=True)
"""
SIGNALS = [signal.SIGINT, signal.SIGTERM]


@pytest.fixture(autouse=True)
def on_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")


def stopped(program: Program, signum: int) -> tuple[int, list[str], str]:
    program.read_until("running")
    _, status, out, err = program.stop(signum)
    return status, sorted(out.splitlines()), err


@pytest.mark.parametrize("signum", SIGNALS)
@pytest.mark.parametrize(
    "place",
    [
        *("loop", "loop in handle", "loop in handshake", "lone node"),
        *("init in constructor", "init in handle"),
    ],
)
def test_a_program_that_loops_on_rclpy_ok_ends_with_its_manager(
    place: str, signum: int, tmp_path: Path
) -> None:
    with running(tmp_path, HOST, place) as program:
        status, out, err = stopped(program, signum)
    # The loop in handle() is interrupted.
    assert (status, out) == (0, ["host ends", "released False", "returned False"]), err
    assert "Traceback" not in err
    assert "Error" not in err


@pytest.mark.parametrize("signum", SIGNALS)
@pytest.mark.parametrize("place", ["constructor", "own constructor"])
def test_it_ends_when_a_signal_comes_while_components_are_built(
    place: str, signum: int, tmp_path: Path
) -> None:
    with running(tmp_path, HOST, place) as program:
        status, out, err = stopped(program, signum)
    # The talker whose own constructor blocked was never built.
    built = ["talker released"] if place == "own constructor" else []
    assert (status, out, err) == (0, ["host ends", *built], "")


@pytest.mark.parametrize("signum", SIGNALS)
def test_a_signal_ends_a_manager_on_a_thread_of_such_a_program(signum: int, tmp_path: Path) -> None:
    # Python gives its signals to the main thread, where rclpy's own handlers are still in place.
    with running(
        tmp_path, HOST.replace("        loop()\n        thread", QUIET), "on a thread"
    ) as p:
        status, out, err = stopped(p, signum)
    assert (status, out) == (0, ["host ends", "host ends", "released False", "returned False"]), err
    assert "so the program ends" in err
    assert "Traceback" not in err


QUIET = """        try:
            loop()
        except KeyboardInterrupt:
            # rclpy calls the handler from before, which is Python's.
            loop()
        thread"""


@pytest.mark.parametrize(
    "place", ["shutdown", "try_shutdown", "shutdown of all", "shutdown of the node's"]
)
def test_a_program_that_shuts_rclpy_down_ends_in_order(place: str, tmp_path: Path) -> None:
    with running(tmp_path, HOST, place) as program:
        program.read_until("running")
        status, out, err = program.end()
    is_ok = "True" if place == "shutdown of the node's" else "False"
    assert (status, sorted(out.splitlines())) == (
        0,
        ["host ends", f"released {is_ok}", "returned False"],
    ), err
    assert err.count("so the program ends") == 1
    assert len(err.splitlines()) == 1, "no timer and no publisher complains of the end"


@pytest.mark.parametrize("place", ["stop", "raise"])
def test_without_a_signal_rclpy_is_there_until_resources_are_released(
    place: str, tmp_path: Path
) -> None:
    with running(tmp_path, HOST, place) as program:
        program.read_until("running")
        status, out, err = program.end()
    lines = sorted(out.splitlines())
    if place == "stop":
        assert (status, lines, err) == (0, ["host ends", "released True", "returned False"], "")
    else:
        assert (status, lines) == (1, ["host ends", "released True"])
        assert "ValueError: no cup" in err


@pytest.mark.parametrize("place", ["shutdown, lent", "init in handle, shutdown"])
def test_a_shutdown_ends_the_manager_whoever_has_initialised_rclpy_and_when(
    place: str, tmp_path: Path
) -> None:
    with running(tmp_path, HOST, place) as program:
        program.read_until("running")
        status, out, err = program.end()
    assert (status, sorted(out.splitlines())) == (
        0,
        ["host ends", "released False", "returned False"],
    ), err
    assert err.count("rclpy has been shut down, so the program ends") == 1
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("signum", SIGNALS)
def test_a_loop_on_rclpy_ok_needs_no_init(signum: int, tmp_path: Path) -> None:
    with running(tmp_path, HOST, "lent") as program:
        status, out, err = stopped(program, signum)
    assert (status, out, err) == (0, ["host ends", "released False", "returned False"], "")


def test_afterwards_signals_do_what_they_did_before_rclpy(tmp_path: Path) -> None:
    source = HOST + "print('waiting', flush=True)\ntime.sleep(100)\n"
    with running(tmp_path, source, "shutdown") as program:
        program.read_until("waiting")
        _, status, _, _ = program.stop(signal.SIGTERM)
    assert status == -signal.SIGTERM


def test_a_second_manager_in_the_same_program_runs(tmp_path: Path) -> None:
    source = HOST + "App(handlers_class=Handlers).start_main_loop_timer()\nprint('again')\n"
    with running(tmp_path, source, "loop") as program:
        program.read_until("running")
        program.process.send_signal(signal.SIGINT)
        status, out, err = stopped(program, signal.SIGTERM)
    assert (status, out) == (0, ["again", "released False"]), err
