"""What programs rely on while a manager is built."""

import inspect
from importlib import import_module
from typing import Any

import pytest

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode
from rosbase.logger import RosbaseLogger
from rosbase.messages import Header
from rosbase.testing import virtual_backend
from support.roles import Brain, Camera, StopAfter


def named(base: Any, name: str, built: list[str]) -> Any:
    """A component class that notes when it is built."""

    class Component(base):  # type: ignore[misc]  # the base is a parameter
        def __init__(self, manager: Any = None, *args: Any, **kwargs: Any) -> None:
            super().__init__(manager, *args, **kwargs)
            built.append(name)

        def reset(self) -> None: ...

    return Component


def test_all_nodes_are_built_in_dict_order_then_all_agents_then_the_handlers() -> None:
    built: list[str] = []
    manager = BaseManager(
        handlers_class=named(BaseHandlers, "h", built),
        agents_dict={name: named(BaseAgent, name, built) for name in "zyx"},
        nodes_dict={name: named(BaseNode, name, built) for name in "cab"},
        backend=virtual_backend(),
    )
    assert built == ["c", "a", "b", "z", "y", "x", "h"]
    assert list(manager.nodes) == ["c", "a", "b"]
    assert list(manager.agents) == ["z", "y", "x"]
    assert type(manager.handlers).__name__ == "Component"
    manager.destroy_node()


def test_a_component_is_given_the_manager_by_name_and_every_extra_argument() -> None:
    given: list[dict[str, Any]] = []

    class Anything:
        def __init__(self, **kwargs: Any) -> None:
            given.append(kwargs)

    manager = BaseManager(
        "orchestrator",
        {"n": Anything},  # type: ignore[dict-item]  # components need no base
        {"a": Anything},  # type: ignore[dict-item]  # components need no base
        Anything,  # type: ignore[arg-type]  # components need no base
        node_freq_hz=10,
        start_state="PREPARE",
        log_freq=False,
        backend=virtual_backend(),
        wait=["img"],
        speed=0.5,
    )
    assert given == [{"manager": manager, "wait": ["img"], "speed": 0.5}] * 3
    manager.destroy_node()


def test_each_component_picks_what_it_knows_and_the_base_classes_ignore_the_rest() -> None:
    class Robot(BaseNode):
        def __init__(self, manager: Any = None, speed: float = 0.0, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.speed = speed

    manager = BaseManager(
        nodes_dict={"robot": Robot, "camera": Camera, "plain": BaseNode},
        agents_dict={"brain": Brain},
        handlers_class=BaseHandlers,
        backend=virtual_backend(),
        gain=3.0,
        speed=0.5,
        nobody_knows="this",
    )
    assert (manager.nodes["robot"].speed, manager.agents["brain"].gain) == (0.5, 3.0)
    manager.destroy_node()


def test_all_is_ready_before_the_first_node_is_built(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", logger="rosbase")
    seen: list[Any] = []

    class First(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            publisher = self.create_publisher(Header, "early", 1)
            self.create_subscription(Header, "early", seen.append, 1)
            self.create_timer(0.01, lambda: publisher.publish(Header()))
            self.logger.info("camera is there")
            seen.append((self.timestamp, self.node_freq_hz, dict(self.nodes), dict(self.agents)))

    manager = BaseManager(
        nodes_dict={"first": First},
        handlers_class=StopAfter,
        node_freq_hz=50,
        backend=virtual_backend(),
    )
    assert seen == [(0, 50, {}, {})]
    assert caplog.messages == ["camera is there"]
    manager.start_main_loop_timer()
    assert seen[1] == Header()


def test_a_later_component_finds_an_earlier_one_and_may_change_it_and_the_dicts() -> None:
    class Tuner(BaseAgent):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.nodes["camera"].exposure = 7
            self.nodes["alias"] = self.nodes["camera"]

        def reset(self) -> None: ...

    manager = BaseManager(
        nodes_dict={"camera": Camera}, agents_dict={"tuner": Tuner}, backend=virtual_backend()
    )
    assert manager.nodes["camera"].exposure == 7
    assert manager.nodes["alias"] is manager.nodes["camera"]
    assert manager.agents["tuner"].nodes is manager.nodes
    assert manager.nodes["camera"].agents is manager.agents
    manager.destroy_node()


def test_a_subclass_may_put_handlers_class_into_kwargs_and_add_rules_afterwards() -> None:
    class PickPlaceRUN(BaseManager):
        def __init__(self, wait: Any = ("img",), *args: Any, **kwargs: Any) -> None:
            kwargs["handlers_class"] = StopAfter
            super().__init__(*args, **kwargs)
            if "img" in wait:
                self.add_handshake_rule("Camera", lambda: self.nodes["camera"].img is not None)

    manager = PickPlaceRUN(nodes_dict={"camera": Camera}, backend=virtual_backend())
    camera = manager.nodes["camera"]
    camera.create_timer(0.3, lambda: camera.publisher.publish(Header()))
    manager.start_main_loop_timer()
    assert (manager.timestamp, camera.img) == (5, Header())


def test_nothing_asks_the_handshake_or_ticks_before_the_start() -> None:
    called: list[str] = []

    class App(BaseManager):
        def handshake(self) -> bool:
            called.append("handshake")
            return True

        def main_loop(self) -> None:
            called.append("main_loop")
            self.request_stop()

        def state_handle(self) -> None:
            called.append("state_handle")

    app = App(nodes_dict={"camera": Camera}, start_state="PREPARE", backend=virtual_backend())
    assert (called, app.state, app.timestamp) == ([], "PREPARE", 0)
    app.start_main_loop_timer()
    assert called == ["handshake", "main_loop"]


def test_main_loop_timer_is_accepted_and_not_forwarded() -> None:
    given: list[dict[str, Any]] = []

    class Node(BaseNode):
        def __init__(self, **kwargs: Any) -> None:
            super().__init__(**kwargs)
            given.append(kwargs)

    manager = BaseManager(nodes_dict={"n": Node}, main_loop_timer=None, backend=virtual_backend())
    assert given == [{"manager": manager}]
    manager.destroy_node()


def test_everything_may_be_left_out() -> None:
    expected = {
        "node_name": "BaseManager",
        "nodes_dict": None,
        "agents_dict": None,
        "handlers_class": None,
        "node_freq_hz": 200,
        "start_state": None,
        "custom_logger": None,
        "log_freq": False,
    }
    parameters = list(inspect.signature(BaseManager).parameters.values())[: len(expected)]
    assert {p.name: p.default for p in parameters} == expected
    assert [p.name for p in parameters] == list(expected), "also by position"
    manager = BaseManager(backend=virtual_backend())
    assert (manager.nodes, manager.agents, manager.handlers, manager.state) == ({}, {}, None, None)
    manager.destroy_node()


def test_two_managers_share_no_components() -> None:
    first, second = (BaseManager(backend=virtual_backend()) for _ in range(2))
    first.nodes["late"] = object()
    assert second.nodes == {}
    first.destroy_node()
    second.destroy_node()


def test_init_custom_variables_is_called_before_the_first_component() -> None:
    class App(BaseManager):
        def init_custom_variables(self) -> None:
            self.goal = f"{self.node_freq_hz} Hz, {self.state}, {self.timestamp}, {self.nodes}"

    class Node(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.goal = manager.goal

    manager = App(
        nodes_dict={"n": Node}, node_freq_hz=10, start_state="a", backend=virtual_backend()
    )
    assert manager.nodes["n"].goal == "10 Hz, a, 0, {}"
    manager.destroy_node()


def test_one_connection_serves_the_manager_and_everything_attached() -> None:
    manager = BaseManager(
        "boss",
        {"camera": Camera},
        {"brain": Brain},
        BaseHandlers,
        backend=virtual_backend(),
    )
    assert manager.handlers is not None
    components = [manager.nodes["camera"], manager.agents["brain"], manager.handlers]
    assert all(component.manager is manager for component in components)
    assert isinstance(manager.logger, RosbaseLogger)
    names = [component.logger.name for component in components]
    assert [manager.logger.name, *names] == ["boss", "boss.camera", "boss", "boss"]
    assert manager.nodes["camera"].get_clock() is manager.agents["brain"].get_clock()
    assert manager.nodes["camera"].get_clock() is manager.backend.clock
    manager.destroy_node()


@pytest.mark.parametrize("module", ["rosbase", "rosbase.manager", "rosbase.manager.base_manager"])
def test_the_functions_for_children_are_where_programs_import_them_from(module: str) -> None:
    home, processes = import_module(module), import_module("rosbase.processes")
    for name in ("register_multiprocess_nodes", "shutdown_multiprocess_nodes"):
        assert getattr(home, name) is getattr(processes, name)
        assert name in home.__all__
