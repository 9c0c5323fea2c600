"""The same node class under a manager and alone."""

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosbase import BaseManager, BaseNode, CallbackReturn, LifecycleNode, State
from rosbase.errors import BackendError
from rosbase.messages import Header
from rosbase.testing import ManualClock, virtual_backend
from support.program import running
from support.roles import Camera


class Sensor(BaseNode):
    """Uses everything that a node has; ends the run by Ctrl-C after some messages."""

    def __init__(self, manager: Any = None, *args: Any, **kwargs: Any) -> None:
        super().__init__(manager, *args, **kwargs)
        self.got: list[Header] = []
        self.frame = str(self.declare_parameter("frame", "base").value)
        self.declare_parameter("messages", 3)
        self.output = self.create_publisher(Header, "~/sample", 10)
        self.input = self.create_subscription(Header, "~/sample", self.keep, 10)
        self.trigger = self.create_timer(0.5, self.measure)
        self.was_released = 0

    def measure(self) -> None:
        self.output.publish(Header(self.get_clock().now(), self.frame))

    def keep(self, message: Header) -> None:
        self.got.append(message)
        if len(self.got) == self.get_parameter("messages").value:
            self.destroy_timer(self.trigger)
            self.destroy_subscription(self.input)
            self.destroy_publisher(self.output)
            self.request_stop()

    def release_resources(self) -> None:
        self.was_released += 1


class App(BaseManager):
    def release_resources(self) -> None:
        for node in self.nodes.values():
            node.release_resources()


def attached(backend: Any) -> Sensor:
    app = App("bot", {"sensor": Sensor}, backend=backend)
    app.start_main_loop_timer()
    node: Sensor = app.nodes["sensor"]
    return node


def alone(backend: Any) -> Sensor:
    node = Sensor(backend=backend)
    node.start_spin_standalone()
    return node


both = pytest.mark.parametrize("run", [attached, alone])


@both
def test_the_same_class_publishes_subscribes_and_keeps_time_and_parameters(
    run: Callable[[Any], Sensor],
) -> None:
    clock = ManualClock(0)
    node = run(virtual_backend(clock, "bot", frame="imu_link"))
    assert [(m.stamp.sec, m.stamp.nanosec, m.frame_id) for m in node.got] == [
        (0, 500_000_000, "imu_link"),
        (1, 0, "imu_link"),
        (1, 500_000_000, "imu_link"),
    ]
    assert (node.output.topic, node.was_released) == ("/bot/sample", 1)
    assert node.get_clock() is clock


@both
def test_the_end_has_cleaned_up_and_doing_it_again_is_harmless(
    run: Callable[[Any], Sensor],
) -> None:
    backend = virtual_backend()
    node = run(backend)
    with pytest.raises(BackendError, match="closed"):
        node.create_publisher(Header, "late")
    node.release_resources()
    node.destroy_node()
    node.destroy_node()
    backend.close()


def test_a_node_with_a_manager_is_not_spun_by_itself() -> None:
    manager = BaseManager(nodes_dict={"camera": Camera}, backend=virtual_backend())
    with pytest.raises(RuntimeError, match="run by the manager"):
        manager.nodes["camera"].start_spin_standalone()
    manager.destroy_node()


def test_destroying_an_attached_node_leaves_the_connection_to_the_manager() -> None:
    manager = BaseManager(nodes_dict={"camera": Camera}, backend=virtual_backend())
    manager.nodes["camera"].destroy_node()
    manager.nodes["camera"].publisher.publish(Header())
    manager.destroy_node()


def test_a_lone_node_sees_nothing_of_a_manager() -> None:
    node = Camera(backend=virtual_backend())
    seen = (node.manager, node.nodes, node.agents, node.timestamp, node.node_freq_hz)
    assert seen == (None, {}, {}, 0, 0.0)
    node.destroy_node()


def test_a_lone_node_is_named_as_it_is_told_or_else_after_its_class() -> None:
    for kwargs, name in (({}, "Camera"), ({"node_name": "front"}, "front")):
        node = Camera(**kwargs)
        assert node.create_publisher(Header, "~/x").topic == f"/{name}/x"
        assert node.logger.name == name
        node.destroy_node()


def test_what_a_lone_node_raises_comes_out_after_its_clean_up() -> None:
    class Bad(Sensor):
        def measure(self) -> None:
            raise ValueError("no sensor")

    node = Bad(backend=virtual_backend())
    with pytest.raises(ValueError, match="no sensor"):
        node.start_spin_standalone()
    assert node.was_released == 1


LONE = """
from rosbase import BaseNode
from rosbase.errors import BackendError
from rosbase.messages import Header

class Node(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_timer(0.01, self.tick)
        self.is_up = False
    def tick(self):
        if not self.is_up:
            print("up", flush=True)
        self.is_up = True
    def release_resources(self):
        print("released", flush=True)

node = Node()
node.start_spin_standalone()
print("returned")
node.release_resources()
node.destroy_node()
try:
    node.create_publisher(Header, "late", 1)
except BackendError as error:
    print(error)
"""


def test_ctrl_c_ends_a_lone_node_that_cleans_up_by_itself(tmp_path: Path) -> None:
    with running(tmp_path, LONE) as program:
        program.read_until("up")
        program.process.send_signal(signal.SIGINT)
        status, out, err = program.end()
    assert (status, err) == (0, "")
    assert out.splitlines()[:3] == ["released", "returned", "released"]
    assert "closed" in out.splitlines()[3]


def test_every_step_of_a_lone_nodes_end_is_attempted_and_the_first_failure_is_raised() -> None:
    done: list[str] = []

    class Device(LifecycleNode):
        autostart = "activate"

        def on_activate(self, previous_state: State) -> CallbackReturn:
            self._request_stop()
            return CallbackReturn.SUCCESS

        def on_deactivate(self, previous_state: State) -> CallbackReturn:
            raise SystemExit(4)

        def release_resources(self) -> None:
            done.append("released")
            raise RuntimeError("release")

    backend = virtual_backend()
    with pytest.raises(SystemExit):
        Device(backend=backend).start_spin_standalone()
    assert done == ["released"]
    assert backend._closed


def test_what_a_callback_of_a_lone_node_raises_is_not_hidden_by_a_clean_up_that_fails() -> None:
    class Bad(BaseNode):
        def release_resources(self) -> None:
            raise RuntimeError("release")

    node = Bad(backend=virtual_backend())

    def fail() -> None:
        raise ValueError("callback")

    node.create_timer(0.1, fail)
    with pytest.raises(ValueError, match="callback"):
        node.start_spin_standalone()
