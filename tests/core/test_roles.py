"""The four roles on the local backend, as far as the IMU reader needs them."""

import threading
from typing import Any

import pytest

from rosbase import (
    BaseAgent,
    BaseHandlers,
    BaseManager,
    BaseNode,
)
from rosbase.errors import HandshakeTimeoutError, NotInstalledError
from rosbase.messages import Header
from rosbase.testing import ManualClock, virtual_backend
from support.roles import Brain, Camera, StopAfter


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
        backend=virtual_backend(),
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
        "m",
        {"holder": Holder},
        None,
        None,
        10,
        None,
        None,
        False,
        1,
        "two",
        backend=virtual_backend(),
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

    manager = Ordered(handlers_class=Handlers, start_state="PREPARE", backend=virtual_backend())
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

    manager = BaseManager(handlers_class=Slow, node_freq_hz=10, backend=virtual_backend(clock))
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
        nodes_dict={"camera": Listener},
        handlers_class=Talk,
        node_freq_hz=100,
        backend=virtual_backend(),
    )
    manager.start_main_loop_timer()
    assert manager.nodes["camera"].img.frame_id == "3"
    assert threads == {threading.get_ident()}


def test_the_handshake_waits_for_messages_and_names_what_is_pending() -> None:
    clock = ManualClock()
    manager = BaseManager(
        nodes_dict={"camera": Camera}, handlers_class=StopAfter, backend=virtual_backend(clock)
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
    manager = BaseManager(backend=virtual_backend(), handshake_timeout=1.0)
    manager.add_handshake_rule("Camera Stream", lambda: False)
    manager.add_handshake_rule("Robot Connection", lambda: 1 / 0)
    manager.add_handshake_rule("Battery", lambda: True)
    with pytest.raises(HandshakeTimeoutError, match=r"Camera Stream, Robot Connection$"):
        manager.start_main_loop_timer()


def test_the_measured_frequency_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", logger="rosbase")
    manager = BaseManager(
        handlers_class=StopAfter, node_freq_hz=1.5, log_freq=True, backend=virtual_backend()
    )
    manager.start_main_loop_timer()
    assert set(caplog.messages) == {"main loop: 1.5 Hz"}


def test_an_agent_works_without_a_manager() -> None:
    agent = Brain(gain=3.0)
    assert (agent.timestamp, agent.state, agent.nodes, agent.agents) == (0, None, {}, {})
    assert agent.get_clock().now().sec > 1_600_000_000
    agent.reset()
    assert agent.gain == 0.0
    with pytest.raises(TypeError, match="abstract"):
        BaseAgent()  # type: ignore[abstract]  # the mistake is the test


def test_handlers_read_and_write_the_state_of_the_manager() -> None:
    manager = BaseManager(handlers_class=BaseHandlers, start_state="a", backend=virtual_backend())
    assert manager.handlers is not None
    manager.handlers.state = "b"
    manager.handlers.timestamp = 7
    assert (manager.state, manager.timestamp) == ("b", 7)
    manager.destroy_node()


def test_a_lone_node_opens_and_closes_its_own_connection() -> None:
    backend = virtual_backend()
    node = Camera(backend=backend)
    released: list[int] = []
    node.release_resources = lambda: released.append(1)  # type: ignore[method-assign]  # the test scripts it
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
