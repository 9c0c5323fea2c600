"""Real rclpy for tests: a domain of their own, executors on threads, a node that is served."""

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import rclpy
import yaml
from lifecycle_msgs import msg, srv
from rcl_interfaces.msg import Parameter as RosParameterMessage
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import get_parameter_value, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.signals import SignalHandlerOptions

from rosbase.contracts.backend import BackendOptions
from rosbase.local import Bus, LocalBackend
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.lifecycle_services import LifecycleServices
from support.ros_domain import own_domain
from support.waiting import wait_until

Open: TypeAlias = Callable[..., Ros2Backend]
"""Opens a backend, given arguments for ROS and options."""

TIMEOUT_S = 20.0


def isolate(log_dir: Path) -> None:
    """Keeps this process and its children apart from other users of ROS on the network.

    To be called before rclpy is first initialised, for the whole process: DDS reads the
    environment only once.
    """
    os.environ |= {
        "ROS_DOMAIN_ID": str(own_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        # The segments of shared memory outlive processes that are killed.
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
        "ROS_LOG_DIR": str(log_dir),
        # A field of the wrong type is published as garbage without this.
        "ROS_PYTHON_CHECK_FIELDS": "1",
    }


@contextmanager
def ros_context() -> Iterator[Any]:
    """A context of rclpy's that touches no signal handler."""
    context: Any = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        yield context
    finally:
        context.try_shutdown()
        context.destroy()


@contextmanager
def spinning(turn: Callable[[], object], name: str) -> Iterator[None]:
    """Has a thread do `turn()` again and again; what it raises is raised at the end."""
    stop = threading.Event()
    errors: list[BaseException] = []

    def spin() -> None:
        try:
            while not stop.is_set():
                turn()
        except BaseException as error:
            errors.append(error)

    thread = threading.Thread(target=spin, name=name)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join(TIMEOUT_S)
    assert not thread.is_alive(), f"the thread of the {name} does not end"
    if errors:
        raise errors[0]


def spin_until(backend: Ros2Backend, is_done: Callable[[], object]) -> None:
    """Runs the main loop of a backend until the condition holds; fails when the time is up."""
    deadline_ns = backend.executor.clock.monotonic_ns() + int(TIMEOUT_S * 1e9)
    while not is_done():
        backend.spin_once(0.1)
        assert backend.executor.clock.monotonic_ns() < deadline_ns, "nothing came"


def params_file(folder: Path, text: str) -> str:
    """A parameter file in a folder; gives its path."""
    file = folder / "params.yaml"
    file.write_text(text)
    return str(file)


class Served:
    """A lifecycle node on a backend of the core, and its services on an rclpy node."""

    def __init__(self, context: Any, executor: Any, kind: type[LifecycleNode]) -> None:
        self.backend = LocalBackend(BackendOptions("served"), Bus())
        self.managed = kind(backend=self.backend)
        self.node: Any = rclpy.create_node("served", context=context)
        self.services = LifecycleServices(
            self.node, self.managed, self.backend.call_soon, self.managed.logger
        )
        self.executor = executor
        executor.add_node(self.node)

    def turn_main_loop(self) -> None:
        """What the thread of the main loop does again and again."""
        self.backend.spin_once(0.1)

    def turn_executor(self) -> None:
        """What the thread of the executor does again and again."""
        self.executor.spin_once(timeout_sec=0.1)

    @property
    def event_readers(self) -> int:
        """How many subscriptions the topic of transitions is connected with."""
        found = [p for p in self.node.publishers if p.topic_name.endswith("/transition_event")]
        return int(found[0].get_subscription_count())

    def destroy(self) -> None:
        """Gives everything back; both threads have ended."""
        self.services.close()
        self.executor.shutdown()
        self.node.destroy_node()
        self.managed.destroy_node()
        self.backend.close()


class Client:
    """Plain rclpy, on the other side of the network."""

    KINDS: ClassVar = {
        "change_state": srv.ChangeState,
        "get_state": srv.GetState,
        "get_available_states": srv.GetAvailableStates,
        "get_available_transitions": srv.GetAvailableTransitions,
        "get_transition_graph": srv.GetAvailableTransitions,
    }

    def __init__(self, context: Any, server: str = "served") -> None:
        self.node: Any = rclpy.create_node("client", context=context)
        self.executor: Any = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.events: list[Any] = []
        self._clients = {
            name: self.node.create_client(kind, f"/{server}/{name}")
            for name, kind in self.KINDS.items()
        }
        self.node.create_subscription(
            msg.TransitionEvent, f"/{server}/transition_event", self.events.append, 10
        )

    def connect(self, served: Served) -> None:
        """Waits until the two have found each other."""
        self.await_services()
        wait_until(lambda: served.event_readers == 1, "the reader of events to be found")

    def await_services(self) -> None:
        """Waits until the five services are there."""
        for client in self._clients.values():
            assert client.wait_for_service(TIMEOUT_S)

    def start(self, name: str, request: Any = None) -> Any:
        """Sends a request, once the service is there; gives the future of the response."""
        assert self._clients[name].wait_for_service(TIMEOUT_S)
        return self._clients[name].call_async(request or self.KINDS[name].Request())

    def finish(self, future: Any) -> Any:
        """The response, when it is here."""
        self.executor.spin_until_future_complete(future, TIMEOUT_S)
        assert future.done(), "no response"
        return future.result()

    def call(self, name: str, request: Any = None) -> Any:
        """Sends a request and gives the response."""
        return self.finish(self.start(name, request))

    def start_change(self, transition_id: int = 0, label: str = "") -> Any:
        """Asks for a transition; gives the future of the response."""
        wanted = msg.Transition(id=transition_id, label=label)
        return self.start("change_state", srv.ChangeState.Request(transition=wanted))

    def change(self, transition_id: int = 0, label: str = "") -> bool:
        """Asks for a transition; tells whether it was a success."""
        return bool(self.finish(self.start_change(transition_id, label)).success)

    def state(self) -> str:
        """The label of the present state."""
        return str(self.call("get_state").current_state.label)

    def await_events(self, count: int) -> list[tuple[int, str, str, str]]:
        """The first so many events, each as id, label, start and goal."""

        def arrived() -> bool:
            self.executor.spin_once(timeout_sec=0.01)
            return len(self.events) >= count

        wait_until(arrived, f"{count} events, not {self.events}")
        return [
            (e.transition.id, e.transition.label, e.start_state.label, e.goal_state.label)
            for e in self.events
        ]

    def destroy(self) -> None:
        """Gives everything back."""
        self.executor.shutdown()
        self.node.destroy_node()


class ParameterTool:
    """What `ros2 param` does, on a node of its own."""

    def __init__(self, context: Any, server: str) -> None:
        self.node: Any = rclpy.create_node("tool", context=context)
        self.executor: Any = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self._server = server
        self._client = AsyncParameterClient(self.node, server)
        wait_until(self._client.services_are_ready, "the parameter services")

    def set(self, name: str, text: str) -> Any:
        """`ros2 param set`: the type is guessed of the text. Gives the result."""
        parameter = RosParameterMessage(name=name, value=get_parameter_value(text))
        return self.finish(self._client.set_parameters([parameter])).results[0]

    def get(self, *names: str) -> list[Any]:
        """The values, as messages."""
        return list(self.finish(self._client.get_parameters(list(names))).values)

    def dump(self) -> str:
        """`ros2 param dump`, as ros2param has it in verb/dump.py."""
        found = self.finish(self._client.list_parameters()).result.names
        tree: dict[str, Any] = {}
        for name, value in zip(sorted(found), self.get(*sorted(found)), strict=True):
            *path, last = name.split(".")
            branch = tree
            for key in path:
                branch = branch.setdefault(key, {})
            branch[last] = parameter_value_to_python(value)
        nodes = {f"/{self._server}": {"ros__parameters": tree}}
        return str(yaml.dump(nodes, default_flow_style=False))

    def finish(self, future: Any) -> Any:
        """The response, when it is here."""
        self.executor.spin_until_future_complete(future, TIMEOUT_S)
        assert future.done(), "no response"
        return future.result()

    def destroy(self) -> None:
        """Gives everything back."""
        self.executor.shutdown()
        self.node.destroy_node()
