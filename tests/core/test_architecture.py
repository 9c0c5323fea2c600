"""How the four roles work together."""

from typing import Any

import pytest

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode
from rosbase.messages import Header, Vector3
from rosbase.testing import virtual_backend
from support.roles import Camera, StopAfter


class Planner(BaseAgent):
    def reset(self) -> None: ...

    def plan(self, image: Header) -> Vector3:
        return Vector3(x=float(image.frame_id))


class Wheels(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.speed = self.create_publisher(Vector3, "speed", 10)


class Drive(StopAfter):
    def handle(self) -> None:
        image = self.nodes["camera"].img
        if image is not None:
            self.nodes["wheels"].speed.publish(self.agents["planner"].plan(image))
        super().handle()


def test_data_goes_from_a_callback_to_a_node_its_handlers_an_agent_and_out_again() -> None:
    backend = virtual_backend()
    arrived: list[float] = []
    backend.create_subscription(Vector3, "speed", lambda speed: arrived.append(speed.x), 10)
    outside = backend.create_publisher(Header, "image", 10)
    backend.create_timer(0.1, lambda: outside.publish(Header(frame_id="0.25")))
    manager = BaseManager(
        nodes_dict={"camera": Camera, "wheels": Wheels},
        agents_dict={"planner": Planner},
        handlers_class=Drive,
        node_freq_hz=10,
        backend=backend,
    )
    manager.start_main_loop_timer()
    assert arrived == [0.25] * len(arrived)
    assert len(arrived) >= 2


def test_an_agent_has_no_publishers_and_no_subscriptions() -> None:
    assert [name for name in dir(BaseAgent) if name.startswith("create")] == []


@pytest.mark.parametrize("component", [BaseHandlers, Planner])
def test_handlers_and_agents_are_nothing_that_the_backend_knows(component: Any) -> None:
    assert not hasattr(component(None), "_backend")


class OwnMachine(StopAfter):
    """Style A: the fine-grained state is the handlers' own."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.current_state, self.prev_state = "ROTATE", ""

    def handle(self) -> None:
        self.prev_state, self.current_state = self.current_state, f"STEP_{self.timestamp}"
        super().handle()


def test_handlers_may_keep_a_machine_of_their_own_and_leave_the_managers_state_alone() -> None:
    manager = BaseManager(
        handlers_class=OwnMachine, start_state="PREPARE", backend=virtual_backend()
    )
    manager.start_main_loop_timer()
    handlers: Any = manager.handlers
    assert (handlers.prev_state, handlers.current_state) == ("STEP_3", "STEP_4")
    assert manager.state == "PREPARE"


class DriveState(StopAfter):
    """Style B: the state is the manager's."""

    manager: Any

    def handle(self) -> None:
        seen = (self.state, self.agents["planner"].state)
        self.state = {"cold_start": "turn", "turn": "navigation"}.get(seen[0] or "", "turn")
        self.manager.seen.append(seen)
        super().handle()


def test_handlers_may_drive_the_managers_state_and_all_see_it() -> None:
    class App(BaseManager):
        def init_custom_variables(self) -> None:
            self.seen: list[tuple[str, str]] = []

    manager = App(
        agents_dict={"planner": Planner},
        handlers_class=DriveState,
        start_state="cold_start",
        backend=virtual_backend(),
    )
    manager.start_main_loop_timer()
    states = ["cold_start", "turn", "navigation", "turn", "navigation"]
    assert manager.seen == list(zip(states, states, strict=True))
    assert manager.state == "turn"


def test_a_managers_end_is_the_place_to_release_what_nodes_and_agents_hold() -> None:
    order: list[str] = []

    class Window(Planner):
        def close(self) -> None:
            order.append("window closed")

    class Bus(BaseNode):
        def release_resources(self) -> None:
            self.create_publisher(Header, "farewell", 1).publish(Header())
            order.append("bus released")

    class App(BaseManager):
        def release_resources(self) -> None:
            for node in self.nodes.values():
                node.release_resources()
            for agent in self.agents.values():
                agent.close()

        def destroy_node(self) -> None:
            order.append("node destroyed")
            super().destroy_node()

    App(
        nodes_dict={"bus": Bus, "plain": BaseNode},
        agents_dict={"window": Window},
        handlers_class=StopAfter,
        backend=virtual_backend(),
    ).start_main_loop_timer()
    assert order == ["bus released", "window closed", "node destroyed"]


def test_a_manager_runs_once_and_needs_no_second_spin() -> None:
    manager = BaseManager(handlers_class=StopAfter, backend=virtual_backend())
    manager.start_main_loop_timer()
    with pytest.raises(RuntimeError, match="runs once"):
        manager.start_main_loop_timer()
    manager.release_resources()
    manager.destroy_node()
    manager.backend.close()
