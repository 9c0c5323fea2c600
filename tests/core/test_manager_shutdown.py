"""Up in order, down in reverse, and all of it whatever happens."""

from typing import Any

import pytest

from rosbase import (
    BaseHandlers,
    BaseManager,
    BaseNode,
    CallbackReturn,
    LifecycleNode,
    State,
)
from rosbase.testing import virtual_backend
from support.roles import Camera, StopAfter


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

    app = App(nodes_dict={"device": Device}, handlers_class=StopAfter, backend=virtual_backend())
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

    backend = virtual_backend()
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

    manager = BaseManager(
        nodes_dict={"d": Device}, handlers_class=StopAfter, backend=virtual_backend()
    )
    manager.nodes["d"].trigger_configure()
    manager.start_main_loop_timer()
    assert manager.timestamp == 5


def test_who_is_to_stop_while_a_node_is_configured_does_not_activate_it_first() -> None:
    trace: list[str] = []

    class Device(LifecycleNode):
        autostart = "activate"

        def on_configure(self, previous_state: State) -> CallbackReturn:
            trace.append("configure")
            self.request_stop()
            return CallbackReturn.SUCCESS

        def on_activate(self, previous_state: State) -> CallbackReturn:
            trace.append("activate")
            return CallbackReturn.SUCCESS

        def on_cleanup(self, previous_state: State) -> CallbackReturn:
            trace.append("cleanup")
            return CallbackReturn.SUCCESS

    BaseManager(nodes_dict={"d": Device}, backend=virtual_backend()).start_main_loop_timer()
    assert trace == ["configure", "cleanup"]


def test_an_exception_in_user_code_cleans_up_and_is_raised() -> None:
    class Bad(BaseHandlers):
        def handle(self) -> None:
            raise KeyError("target")

    released: list[int] = []

    class App(BaseManager):
        def release_resources(self) -> None:
            released.append(1)

    with pytest.raises(KeyError, match="target"):
        App(handlers_class=Bad, backend=virtual_backend()).start_main_loop_timer()
    assert released == [1]


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
    manager = BaseManager(nodes_dict=nodes, handlers_class=Look, backend=virtual_backend())
    manager.start_main_loop_timer()
    assert trace == ["a up", "b up", "c up", "b down", "a down"]
    assert "activate failed, now inactive: no reason" in caplog.text
    assert "c" in states
    assert states["c"] is State.UNCONFIGURED, "the one that failed gives back what it took"


def test_building_a_component_that_raises_closes_the_backend() -> None:
    class Bad(BaseNode):
        def __init__(self, **kwargs: Any) -> None:
            raise ValueError("no camera")

    backend = virtual_backend()
    with pytest.raises(ValueError, match="no camera"):
        BaseManager(nodes_dict={"camera": Camera, "bad": Bad}, backend=backend)
    assert backend._closed
