"""Services in programs: calls from handle(), between processes, and the stop while one waits."""

import math
import signal
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from rosbase import BackendOptions, BaseHandlers, BaseManager, BaseNode
from rosbase.messages.std_srvs import SetBool
from rosbase_ros2.backend import Ros2Backend
from support.program import running
from support.ros import TIMEOUT_S
from support.waiting import wait_until

PLAIN_SERVER = """
    import warnings
    warnings.simplefilter("ignore", DeprecationWarning)
    import rclpy
    from std_srvs.srv import SetBool

    def answer(request, response):
        response.success = not request.data
        return response

    rclpy.init()
    node = rclpy.create_node("plain")
    node.create_service(SetBool, "opposite", answer)
    print("serving", flush=True)
    try:
        rclpy.spin(node)
    except BaseException:
        pass
"""
PERIOD_S = 1 / 200


class Asker(BaseNode):
    """Has a client of the service."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.client = self.create_client(SetBool, "opposite")


class Server(Asker):
    """Has the service too."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.create_service(SetBool, "opposite", self.answer)

    def answer(self, request: Any) -> Any:
        return SetBool.Response(success=not request.data)


class Asking(BaseHandlers):
    """Calls the service once a tick."""

    def __init__(self, manager: BaseManager, *args: Any, **kwargs: Any) -> None:
        super().__init__(manager, *args, **kwargs)
        self.took_s: list[float] = []
        self.skipped: list[int] = []

    def handle(self) -> None:
        client, stats = self.node(Asker).client, self.manager.loop_stats
        if self.timestamp == 0:
            # Discovery takes some ticks.
            assert client.wait_for_service(TIMEOUT_S)
            return
        self.skipped.append(stats.overruns)
        if self.timestamp == 1001:
            self.manager.request_stop()
            return
        start, data = time.perf_counter(), self.timestamp % 2 == 0
        assert client.call(SetBool.Request(data=data)).success is not data
        self.took_s.append(time.perf_counter() - start)


def ask_a_thousand_times(asker: type[Asker]) -> None:
    """Runs a manager at 200 Hz; checks that a call costs no other ticks than those of its time."""
    manager = BaseManager(
        nodes_dict={"asker": asker},
        handlers_class=Asking,
        node_freq_hz=200,
        backend=Ros2Backend(BackendOptions("app")),
    )
    manager.start_main_loop_timer()
    handlers: Any = manager.handlers
    assert len(handlers.took_s) == 1000
    without_cause = sum(
        after - before > math.ceil(took_s / PERIOD_S - 0.5)
        for took_s, (before, after) in zip(handlers.took_s, pairwise(handlers.skipped), strict=True)
    )
    # The machine may stall. At rest, there are none.
    assert without_cause <= 20


def test_a_thousand_calls_of_the_same_manager_are_answered() -> None:
    ask_a_thousand_times(Server)


def test_a_thousand_calls_of_a_process_without_rosbase_are_answered(tmp_path: Path) -> None:
    with running(tmp_path, PLAIN_SERVER) as program:
        program.read_until("serving")
        ask_a_thousand_times(Asker)


# Two managers that call each other in every tick.
MUTUAL = """
    import sys, warnings
    warnings.simplefilter("ignore", DeprecationWarning)
    from rosbase import BaseHandlers, BaseManager, BaseNode
    from rosbase.messages.std_srvs import SetBool

    own, other = sys.argv[1:]

    class Node(BaseNode):
        def __init__(self, manager=None, **kwargs):
            super().__init__(manager, **kwargs)
            self.create_service(SetBool, f"/{own}/opposite", self.answer)
            self.client = self.create_client(SetBool, f"/{other}/opposite")
            self.create_service(SetBool, f"/{own}/end", self.end)
            self.over = self.create_client(SetBool, f"/{other}/end")
            self.is_other_done = False

        def answer(self, request):
            return SetBool.Response(success=not request.data)

        def end(self, request):
            self.is_other_done = True
            return SetBool.Response(success=True)

    class Handlers(BaseHandlers):
        def handle(self):
            node = self.node(Node)
            if self.timestamp < 300:
                data = self.timestamp % 2 == 0
                answer = node.client.call(SetBool.Request(data=data), timeout_s=20.0)
                assert answer.success is not data
            elif self.timestamp == 300:
                node.over.call(SetBool.Request(), timeout_s=20.0)
                print("answered", flush=True)
            elif node.is_other_done:
                self.manager.request_stop()

    manager = BaseManager(own, {"node": Node}, handlers_class=Handlers, node_freq_hz=200)
    manager.start_main_loop_timer()
"""


def test_two_managers_in_two_processes_that_call_each_other_get_answers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")
    with running(tmp_path, MUTUAL, "a", "b") as a, running(tmp_path, MUTUAL, "b", "a") as b:
        # The first that ends comes first: if one fails, the other waits for it in vain.
        wait_until(lambda: {a.process.poll(), b.process.poll()} != {None}, "an end", 40.0)
        for program in sorted((a, b), key=lambda one: one.process.poll() is None):
            status, out, err = program.end()
            assert (status, out) == (0, "answered\n"), err


WAITING = """
    import sys, threading, warnings
    warnings.simplefilter("ignore", DeprecationWarning)
    import rclpy
    from rosbase import BaseHandlers, BaseManager, BaseNode
    from rosbase.messages.std_srvs import Trigger

    class Node(BaseNode):
        def __init__(self, manager=None, **kwargs):
            super().__init__(manager, **kwargs)
            self.client = self.create_client(Trigger, "absent")

    class Handlers(BaseHandlers):
        def handle(self):
            print("waiting", flush=True)
            if sys.argv[1:] == ["rclpy"]:
                threading.Timer(0.2, rclpy.shutdown).start()
            self.node(Node).client.call(Trigger.Request(), timeout_s=600.0)

    BaseManager("app", {"node": Node}, handlers_class=Handlers).start_main_loop_timer()
"""


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_program_that_waits_for_a_service(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, signum: int
) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")
    with running(tmp_path, WAITING) as program:
        program.read_until("waiting")
        took_s, status, _, err = program.stop(signum)
    assert status == 0, err
    assert took_s < 5.0


def test_a_shutdown_of_rclpy_ends_a_program_that_waits_for_a_service(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")
    with running(tmp_path, WAITING, "rclpy") as program:
        status, _, err = program.end()
    assert status == 0, err
