"""Services in programs: calls from handle(), and the stop while one waits."""

import signal
import threading
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    BackendOptions,
    BaseHandlers,
    BaseManager,
    BaseNode,
    CallbackReturn,
    LifecycleNode,
    LocalBackend,
    ServiceStoppedError,
    State,
)
from rosbase.local import Bus
from rosbase.testing import virtual_backend
from support.program import running
from support.services import Double, double
from support.waiting import wait_until


class Doubler(BaseNode):
    """Has the service and its client."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.create_service(Double, "double", double)
        self.client = self.create_client(Double, "double")
        self.absent = self.create_client(Double, "absent")


class Asking(BaseHandlers):
    """Calls the service of its own manager, five times a tick."""

    def handle(self) -> None:
        client = self.node(Doubler).client
        for number in range(5):
            assert client.call(Double.Request(number)).number == 2 * number
        if self.timestamp == 199:
            self.manager.request_stop()


@pytest.mark.parametrize("timing", ["normal", "precise"])
def test_a_thousand_calls_from_handle_are_all_answered(timing: Any) -> None:
    manager = BaseManager(
        nodes_dict={"doubler": Doubler},
        handlers_class=Asking,
        backend=LocalBackend(BackendOptions("app"), Bus()),
        timing=timing,
    )
    manager.start_main_loop_timer()
    assert manager.timestamp == 200
    assert manager.node(Doubler).client.dropped == 0


def test_calls_from_handle_skip_no_tick_but_those_of_their_own_time() -> None:
    class Handlers(BaseHandlers):
        def handle(self) -> None:
            node = self.node(Doubler)
            node.client.call(Double.Request())
            if self.timestamp == 20:
                # 3.2 periods.
                assert not node.absent.wait_for_service(0.016)
            if self.timestamp == 99:
                self.manager.request_stop()

    manager = BaseManager(
        nodes_dict={"doubler": Doubler}, handlers_class=Handlers, backend=virtual_backend()
    )
    manager.start_main_loop_timer()
    assert (manager.timestamp, manager.loop_stats.overruns) == (100, 2)


def test_two_managers_that_call_each_other_at_the_same_time_both_get_answers() -> None:
    bus, together = Bus(), threading.Barrier(2)

    class Node(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.create_service(Double, "~/double", double)
            self.client = self.create_client(Double, f"/{kwargs['other']}/double")

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            if self.timestamp < 50:
                together.wait(20.0)
                assert self.node(Node).client.call(Double.Request(4)).number == 8
            else:
                self.manager.request_stop()

    def run(name: str, other: str) -> None:
        manager = BaseManager(
            name,
            {"node": Node},
            handlers_class=Handlers,
            backend=LocalBackend(BackendOptions(name), bus),
            other=other,
        )
        ready.wait(20.0)
        manager.start_main_loop_timer()
        ended.append(manager.timestamp)

    ready, ended = threading.Barrier(2), list[int]()
    threads = [threading.Thread(target=run, args=pair) for pair in (("a", "b"), ("b", "a"))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20.0)
    assert ended == [51, 51]


# The stop.


def test_a_stop_ends_a_wait_and_the_clean_up_may_call() -> None:
    words: list[Any] = []

    class Node(Doubler):
        def release_resources(self) -> None:
            words.append("node")

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            waiting.set()
            try:
                self.node(Doubler).absent.call(Double.Request(), timeout_s=1000.0)
            finally:
                words.append("handle")

    class App(BaseManager):
        def release_resources(self) -> None:
            words.append(self.node(Doubler).client.call(Double.Request(4)).number)

    waiting = threading.Event()
    backend = LocalBackend(BackendOptions("app"), Bus())
    manager = App(nodes_dict={"node": Node}, handlers_class=Handlers, backend=backend)

    def stop() -> None:
        waiting.wait(20.0)
        wait_until(lambda: backend.executor.depth == 1, "the call")
        manager.request_stop()

    thread = threading.Thread(target=stop)
    thread.start()
    manager.start_main_loop_timer()
    thread.join(20.0)
    assert words == ["handle", 8]


def test_a_call_after_the_stop_does_not_begin() -> None:
    class Handlers(BaseHandlers):
        def handle(self) -> None:
            self.manager.request_stop()
            for wait in (
                lambda: self.node(Doubler).client.call(Double.Request()),
                self.node(Doubler).client.wait_for_service,
            ):
                with pytest.raises(ServiceStoppedError, match=r"/double: .* asked to stop"):
                    wait()

    backend = virtual_backend()
    BaseManager(
        nodes_dict={"doubler": Doubler}, handlers_class=Handlers, backend=backend
    ).start_main_loop_timer()


def test_a_stop_ends_the_wait_of_another_thread() -> None:
    errors: list[Exception] = []

    class Worker(Doubler):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.thread = threading.Thread(target=self.work)
            self.thread.start()

        def work(self) -> None:
            try:
                self.absent.call(Double.Request(), timeout_s=1000.0)
            except ServiceStoppedError as error:
                errors.append(error)

        def release_resources(self) -> None:
            self.thread.join(20.0)

    backend = LocalBackend(BackendOptions("app"), Bus())
    node = Worker(backend=backend)
    node.create_timer(0.01, node.request_stop)
    node.start_spin_standalone()
    assert len(errors) == 1


def test_a_stop_in_a_service_ends_the_call_that_waits_for_it(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Node(Doubler):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.create_service(Double, "stop", self.stop)

        def stop(self, request: Double.Request) -> Double.Response:
            self.request_stop()
            return self.client.call(request)

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            self.node(Node).create_client(Double, "stop").call(Double.Request())

    BaseManager(
        nodes_dict={"node": Node}, handlers_class=Handlers, backend=virtual_backend()
    ).start_main_loop_timer()
    assert not [record for record in caplog.records if record.levelname == "ERROR"]


def test_a_transition_that_a_stop_ends_is_no_failure(caplog: pytest.LogCaptureFixture) -> None:
    class Arm(LifecycleNode):
        autostart = "activate"

        def on_configure(self, previous_state: State) -> CallbackReturn:
            self.create_timer(0.01, self.request_stop)
            self.request_stop()
            self.create_client(Double, "absent").call(Double.Request())
            return CallbackReturn.SUCCESS

    node = Arm(backend=virtual_backend())
    node.start_spin_standalone()
    assert node.get_state() is State.FINALIZED
    assert "Traceback" not in caplog.text


PROGRAM = """
import sys
from rosbase import BaseHandlers, BaseManager, BaseNode, CallbackReturn, LifecycleNode

class Double:
    class Request: ...
    class Response: ...

class Node(LifecycleNode):
    autostart = "activate"
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.absent = self.create_client(Double, "absent")
        self.create_subscription(Double, "topic", self.block)
        self.sender = super(LifecycleNode, self).create_publisher(Double, "topic")
        if sys.argv[1] == "constructor":
            self.block()
    def on_configure(self, previous_state):
        if sys.argv[1] == "on_configure":
            self.block()
        return CallbackReturn.SUCCESS
    def block(self, message=None):
        print("blocking", flush=True)
        self.absent.call(Double.Request(), timeout_s=60.0)
        print("not reached", flush=True)
    def release_resources(self):
        print("released node", flush=True)

class Handlers(BaseHandlers):
    def handle(self):
        if sys.argv[1] == "handle":
            self.node(Node).block()
        if sys.argv[1] == "stubborn":
            print("blocking", flush=True)
            while True:
                try:
                    self.node(Node).absent.call(Double.Request(), timeout_s=60.0)
                except Exception:
                    pass
        if sys.argv[1] == "callback":
            self.node(Node).sender.publish(Double())
        if sys.argv[1] == "clean-up":
            self.manager.request_stop()

class App(BaseManager):
    def handshake(self):
        if sys.argv[1] == "handshake":
            self.node(Node).block()
    def release_resources(self):
        if sys.argv[1] == "clean-up":
            self.node(Node).block()
        print("released", flush=True)

if __name__ == "__main__":
    App("app", {"node": Node}, None, Handlers).start_main_loop_timer()
    print("ended", flush=True)
"""

PLACES = ["handle", "handshake", "callback", "on_configure", "stubborn"]


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("place", PLACES)
def test_a_signal_ends_a_call_that_waits_and_the_whole_clean_up_runs(
    place: str, signum: int, tmp_path: Path
) -> None:
    with running(tmp_path, PROGRAM, place) as program:
        program.read_until("blocking")
        took_s, status, out, err = program.stop(signum)
    assert status == 0, err
    assert out.split("\n") == ["released", "ended", ""]
    assert "Traceback" not in err
    assert took_s < 5.0


def test_a_signal_ends_a_constructor_that_calls(tmp_path: Path) -> None:
    with running(tmp_path, PROGRAM, "constructor") as program:
        program.read_until("blocking")
        took_s, status, out, err = program.stop(signal.SIGTERM)
    assert (status, out, err) == (0, "", "")
    assert took_s < 10.0


def test_a_second_signal_ends_a_call_of_the_clean_up(tmp_path: Path) -> None:
    with running(tmp_path, PROGRAM, "clean-up") as program:
        program.read_until("blocking")
        program.process.send_signal(signal.SIGTERM)
        # Within a second they would be one wish.
        threading.Event().wait(1.2)
        took_s, status, out, err = program.stop(signal.SIGTERM)
    assert status == 0, err
    assert out == "ended\n"
    assert "release_resources was interrupted by a signal" in err
    assert took_s < 5.0
