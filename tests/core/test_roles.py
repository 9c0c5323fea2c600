"""The four roles on the local backend, as far as the IMU reader needs them."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
from typing import Any

import pytest

from rosbase import (
    BaseAgent,
    BaseHandlers,
    BaseManager,
    BaseNode,
    CallbackReturn,
    LifecycleNode,
    State,
)
from rosbase.backend import BackendOptions
from rosbase.errors import HandshakeTimeoutError, NotInstalledError
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Header
from support.clocks import ManualClock


def local(clock: ManualClock | None = None) -> LocalBackend:
    return LocalBackend(BackendOptions("test", clock=clock or ManualClock()), Bus())


class Camera(BaseNode):
    def __init__(self, manager: Any = None, *args: Any, **kwargs: Any) -> None:
        super().__init__(manager, *args, **kwargs)
        self.img: Header | None = None
        self.create_subscription(Header, "image", self._keep, 1)
        self.publisher = self.create_publisher(Header, "image", 1)

    def _keep(self, message: Header) -> None:
        self.img = message


class Brain(BaseAgent):
    def __init__(self, manager: Any = None, *args: Any, gain: float = 1.0, **kwargs: Any) -> None:
        super().__init__(manager, *args, **kwargs)
        self.gain = gain

    def reset(self) -> None:
        self.gain = 0.0


class StopAfter(BaseHandlers):
    ticks = 5

    def handle(self) -> None:
        if self.timestamp + 1 >= self.ticks:
            self.manager.request_stop()


def test_components_are_built_in_order_and_see_each_other() -> None:
    seen: list[str] = []

    class First(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            seen.append(f"first {sorted(self.nodes)} {self.timestamp} {kwargs['gain']}")

    class Second(BaseAgent):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            seen.append(f"second {sorted(self.nodes)} {self.state}")

        def reset(self) -> None: ...

    class Last(BaseHandlers):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            seen.append(f"last {sorted(self.nodes)} {sorted(self.agents)}")

    manager = BaseManager(
        nodes_dict={"first": First},
        agents_dict={"second": Second},
        handlers_class=Last,
        start_state="PREPARE",
        backend=local(),
        gain=2,
    )
    assert seen == ["first [] 0 2", "second ['first'] PREPARE", "last ['first'] ['second']"]
    manager.destroy_node()


def test_positional_arguments_are_forwarded_as_given() -> None:
    class Holder(BaseNode):
        def __init__(self, manager: Any, *args: Any) -> None:
            super().__init__(manager, *args)
            self.given = args

    manager = BaseManager(
        "m", {"holder": Holder}, None, None, 10, None, None, False, 1, "two", backend=local()
    )
    assert manager.nodes["holder"].given == (1, "two")
    manager.destroy_node()


def test_each_tick_has_its_order_and_the_first_sees_zero() -> None:
    trace: list[Any] = []

    class Ordered(BaseManager):
        def get_state_switch(self) -> str | None:
            trace.append(("switch", self.timestamp))
            return "RUN" if self.timestamp == 1 else None

        def state_handle(self, switch: str | None) -> None:
            trace.append(("handle_state", switch, self.state))

    class Handlers(StopAfter):
        ticks = 2

        def handle(self) -> None:
            trace.append(("handle", self.state))
            super().handle()

    manager = Ordered(handlers_class=Handlers, start_state="PREPARE", backend=local())
    manager.start_main_loop_timer()
    assert trace == [
        ("switch", 0),
        ("handle_state", None, "PREPARE"),
        ("handle", "PREPARE"),
        ("switch", 1),
        ("handle_state", "RUN", "RUN"),
        ("handle", "RUN"),
    ]
    assert manager.timestamp == 2


def test_the_rate_is_kept_and_missed_ticks_are_skipped_and_counted() -> None:
    clock = ManualClock()
    starts: list[float] = []

    class Slow(StopAfter):
        def handle(self) -> None:
            starts.append(clock.elapsed_ns / 1e9)
            if self.timestamp == 1:
                clock.advance(0.35)
            super().handle()

    manager = BaseManager(handlers_class=Slow, node_freq_hz=10, backend=local(clock))
    manager.start_main_loop_timer()
    assert starts == pytest.approx([0.0, 0.1, 0.45, 0.5, 0.6])
    assert (manager.loop_stats.ticks, manager.loop_stats.overruns) == (5, 2)


def test_messages_are_handled_between_ticks_on_the_same_thread() -> None:
    threads: set[int] = set()

    class Listener(Camera):
        def _keep(self, message: Header) -> None:
            threads.add(threading.get_ident())
            super()._keep(message)

    class Talk(StopAfter):
        def handle(self) -> None:
            threads.add(threading.get_ident())
            self.nodes["camera"].publisher.publish(Header(frame_id=str(self.timestamp)))
            super().handle()

    manager = BaseManager(
        nodes_dict={"camera": Listener}, handlers_class=Talk, node_freq_hz=100, backend=local()
    )
    manager.start_main_loop_timer()
    assert manager.nodes["camera"].img.frame_id == "3"
    assert threads == {threading.get_ident()}


def test_the_handshake_waits_for_messages_and_names_what_is_pending() -> None:
    clock = ManualClock()
    manager = BaseManager(
        nodes_dict={"camera": Camera}, handlers_class=StopAfter, backend=local(clock)
    )
    camera = manager.nodes["camera"]
    asked: list[bool] = []

    def has_image() -> bool:
        asked.append(camera.img is not None)
        return asked[-1]

    manager.add_handshake_rule("Camera Stream", has_image)
    camera.create_timer(0.35, lambda: camera.publisher.publish(Header()))
    manager.start_main_loop_timer()
    assert asked[-1]
    assert not any(asked[:-1])
    assert len(asked) > 3


def test_a_handshake_that_times_out_names_the_pending_rules_and_cleans_up() -> None:
    manager = BaseManager(backend=local(), handshake_timeout=1.0)
    manager.add_handshake_rule("Camera Stream", lambda: False)
    manager.add_handshake_rule("Robot Connection", lambda: 1 / 0)
    manager.add_handshake_rule("Battery", lambda: True)
    with pytest.raises(HandshakeTimeoutError, match=r"Camera Stream, Robot Connection$"):
        manager.start_main_loop_timer()


def test_every_step_of_the_shutdown_is_attempted_in_order() -> None:
    done: list[str] = []

    class Device(LifecycleNode):
        autostart = "activate"

        def on_deactivate(self, previous_state: State) -> CallbackReturn:
            done.append("deactivate")
            return CallbackReturn.SUCCESS

        def on_cleanup(self, previous_state: State) -> CallbackReturn:
            done.append("cleanup")
            raise OSError("stuck")

        def on_shutdown(self, previous_state: State) -> CallbackReturn:
            done.append("shutdown")
            return CallbackReturn.SUCCESS

    class App(BaseManager):
        def release_resources(self) -> None:
            done.append("release")
            raise ValueError("window")

        def destroy_node(self) -> None:
            done.append("destroy")
            super().destroy_node()

    app = App(nodes_dict={"device": Device}, handlers_class=StopAfter, backend=local())
    with pytest.raises(ValueError, match="window"):
        app.start_main_loop_timer()
    assert done == ["deactivate", "cleanup", "shutdown", "release", "destroy"]
    assert app.nodes["device"].get_state() is State.FINALIZED


def test_a_node_that_exits_does_not_keep_the_others_from_being_taken_down() -> None:
    done: list[str] = []

    class Quiet(LifecycleNode):
        autostart = "activate"

        def on_shutdown(self, previous_state: State) -> CallbackReturn:
            done.append("quiet")
            return CallbackReturn.SUCCESS

    class Exits(LifecycleNode):
        autostart = "activate"

        def on_deactivate(self, previous_state: State) -> CallbackReturn:
            raise SystemExit(3)

    class App(BaseManager):
        def release_resources(self) -> None:
            done.append("release")

    backend = local()
    app = App(
        nodes_dict={"quiet": Quiet, "exits": Exits}, handlers_class=StopAfter, backend=backend
    )
    with pytest.raises(SystemExit):
        app.start_main_loop_timer()
    assert done == ["quiet", "release"]
    assert app.nodes["exits"].get_state() is State.FINALIZED
    assert backend._closed


def test_a_node_that_is_up_already_is_left_up() -> None:
    class Device(LifecycleNode):
        autostart = "activate"

    manager = BaseManager(nodes_dict={"d": Device}, handlers_class=StopAfter, backend=local())
    manager.nodes["d"].trigger_configure()
    manager.start_main_loop_timer()
    assert manager.timestamp == 5


def test_the_measured_frequency_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", logger="rosbase")
    manager = BaseManager(
        handlers_class=StopAfter, node_freq_hz=1.5, log_freq=True, backend=local()
    )
    manager.start_main_loop_timer()
    assert set(caplog.messages) == {"main loop: 1.5 Hz"}


def test_an_exception_in_user_code_cleans_up_and_is_raised() -> None:
    class Bad(BaseHandlers):
        def handle(self) -> None:
            raise KeyError("target")

    released: list[int] = []

    class App(BaseManager):
        def release_resources(self) -> None:
            released.append(1)

    with pytest.raises(KeyError, match="target"):
        App(handlers_class=Bad, backend=local()).start_main_loop_timer()
    assert released == [1]


def test_building_a_component_that_raises_closes_the_backend() -> None:
    class Bad(BaseNode):
        def __init__(self, **kwargs: Any) -> None:
            raise ValueError("no camera")

    backend = local()
    with pytest.raises(ValueError, match="no camera"):
        BaseManager(nodes_dict={"camera": Camera, "bad": Bad}, backend=backend)
    assert backend._closed


def test_lifecycle_nodes_come_up_in_order_and_are_rolled_back(
    caplog: pytest.LogCaptureFixture,
) -> None:
    states: dict[str, State] = {}

    class Look(StopAfter):
        def handle(self) -> None:
            states.update({name: node.get_state() for name, node in self.nodes.items()})
            super().handle()

    trace: list[str] = []

    def device(name: str, answer: CallbackReturn) -> type[LifecycleNode]:
        class Device(LifecycleNode):
            autostart = "activate"

            def on_activate(self, previous_state: State) -> CallbackReturn:
                trace.append(f"{name} up")
                return answer

            def on_deactivate(self, previous_state: State) -> CallbackReturn:
                trace.append(f"{name} down")
                return CallbackReturn.SUCCESS

        return Device

    good, bad = CallbackReturn.SUCCESS, CallbackReturn.FAILURE
    nodes = {"a": device("a", good), "b": device("b", good), "c": device("c", bad)}
    manager = BaseManager(nodes_dict=nodes, handlers_class=Look, backend=local())
    manager.start_main_loop_timer()
    assert trace == ["a up", "b up", "c up", "b down", "a down"]
    assert "activate failed, now inactive: no reason" in caplog.text
    assert "c" in states
    assert states["c"] is State.UNCONFIGURED, "the one that failed gives back what it took"


def test_an_agent_works_without_a_manager() -> None:
    agent = Brain(gain=3.0)
    assert (agent.timestamp, agent.state, agent.nodes, agent.agents) == (0, None, {}, {})
    assert agent.get_clock().now().sec > 1_600_000_000
    agent.reset()
    assert agent.gain == 0.0
    with pytest.raises(TypeError, match="abstract"):
        BaseAgent()  # type: ignore[abstract]


def test_handlers_read_and_write_the_state_of_the_manager() -> None:
    manager = BaseManager(handlers_class=BaseHandlers, start_state="a", backend=local())
    assert manager.handlers is not None
    manager.handlers.state = "b"
    manager.handlers.timestamp = 7
    assert (manager.state, manager.timestamp) == ("b", 7)
    manager.destroy_node()


def test_a_lone_node_opens_and_closes_its_own_connection() -> None:
    backend = local()
    node = Camera(backend=backend)
    released: list[int] = []
    node.release_resources = lambda: released.append(1)  # type: ignore[method-assign]
    node.publisher.publish(Header(frame_id="x"))
    node.create_timer(0.5, node._request_stop)
    node.start_spin_standalone()
    assert node.img == Header(frame_id="x")
    assert released == [1]
    node.destroy_node()


def test_the_environment_names_the_backend(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2x")
    with pytest.raises(NotInstalledError, match="no backend 'ros2x'; installed: local"):
        BaseManager()


APP = """
import sys
from rosbase import BaseHandlers, BaseManager

class Handlers(BaseHandlers):
    def handle(self):
        if self.timestamp == 0:
            print("running", flush=True)

class App(BaseManager):
    def release_resources(self):
        print("released", flush=True)
        {hang}

App(handlers_class=Handlers).start_main_loop_timer()
print("returned", flush=True)
"""


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_and_cleans_up_without_a_traceback(signum: int) -> None:
    code = textwrap.dedent(APP).format(hang="pass")
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as app:
        assert app.stdout is not None
        assert app.stdout.readline() == "running\n"
        app.send_signal(signum)
        out, err = app.communicate(timeout=20)
    assert (app.returncode, out, err) == (0, "released\nreturned\n", "")


def test_a_second_signal_forces_the_end() -> None:
    code = textwrap.dedent(APP).format(hang="import time; time.sleep(100)")
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as app:
        assert app.stdout is not None
        assert app.stdout.readline() == "running\n"
        app.send_signal(signal.SIGINT)
        assert app.stdout.readline() == "released\n"
        app.send_signal(signal.SIGINT)
        app.communicate(timeout=20)
    assert app.returncode == 128 + signal.SIGINT
    assert os.WIFEXITED(app.returncode << 8)
