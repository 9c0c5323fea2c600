"""The same lifecycle node twice, by rclpy and by rosbase, and whoever puts questions to it."""

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
from lifecycle_msgs.msg import TransitionEvent
from lifecycle_msgs.srv import GetState
from rcl_interfaces.msg import ParameterEvent
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import NodeNameNonExistentError

from support.waiting import wait_until

ATTEMPTS = 20

QUIET = """
import warnings
# rclpy imports a parser that imports what Python has deprecated.
warnings.simplefilter("ignore", DeprecationWarning)
import time
from std_msgs.msg import String
"""

BODY = """
    def on_configure(self, state):
        answer = self.get_parameter("answer").value
        if answer == "raise":
            raise ValueError("no arm")
        if answer == "slow":
            time.sleep(1.0)
        return getattr(Answer, "SUCCESS" if answer == "slow" else answer.upper())

    def on_activate(self, state):
        return super().on_activate(state)

    def on_deactivate(self, state):
        return super().on_deactivate(state)

    def on_cleanup(self, state):
        return Answer.SUCCESS

    def on_shutdown(self, state):
        return Answer.SUCCESS

    def on_error(self, state):
        return Answer.SUCCESS

    def make_topics(self):
        self.sender = PUBLISH(self)(String, "joints", 7)
        self.create_subscription(String, "goal", lambda message: None, 5)
        self.create_timer(0.05, lambda: self.sender.publish(String(data="up")))
"""

THEIRS = (
    QUIET
    + """
import rclpy
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn as Answer

PUBLISH = lambda node: node.create_lifecycle_publisher


class Arm(LifecycleNode):
    def __init__(self):
        super().__init__("arm")
        self.declare_parameter("answer", "success")
        speed = FloatingPointRange(from_value=0.0, to_value=2.0)
        speed = ParameterDescriptor(description="m/s", floating_point_range=[speed])
        self.declare_parameter("motion.speed", 0.5, speed)
        joints = IntegerRange(from_value=1, to_value=9)
        self.declare_parameter("joints", 6, ParameterDescriptor(integer_range=[joints]))
        self.declare_parameter("motion.is_soft", True)
        self.declare_parameter("gains", [1.0, 2.0])
        self.declare_parameter("names", ["base", "hand"])
        self.declare_parameter("serial", "A1", ParameterDescriptor(read_only=True))
        self.make_topics()
"""
    + BODY
    + """

rclpy.init()
rclpy.spin(Arm())
"""
)

OURS = (
    QUIET
    + """
from rosbase import CallbackReturn as Answer, LifecycleNode, ParameterSpec

PUBLISH = lambda node: node.create_publisher


class Arm(LifecycleNode):
    def __init__(self):
        super().__init__(node_name="arm", backend="ros2")
        self.declare_parameter("answer", "success")
        for spec in (
            ParameterSpec("motion.speed", 0.5, "m/s", minimum=0.0, maximum=2.0),
            ParameterSpec("joints", 6, minimum=1, maximum=9),
            ParameterSpec("serial", "A1", read_only=True),
        ):
            self.declare_parameter(spec.name, spec.default, spec)
        self.declare_parameter("motion.is_soft", True)
        self.declare_parameter("gains", [1.0, 2.0])
        self.declare_parameter("names", ["base", "hand"])
        self.make_topics()
"""
    + BODY
    + """

Arm().start_spin_standalone()
"""
)


class UndiscoveredError(Exception):
    """Two nodes, or a client and a service, have not found each other in time.

    Neither says so: requests are not answered. A new pair finds each other.
    """


class Asker:
    """A plain rclpy node that puts questions to a node in another process."""

    def __init__(
        self, context: Any, target: str, process: "subprocess.Popen[str]", err: Path
    ) -> None:
        """Take the full name of the node that is asked, its process, and what that has written."""
        self.target = target
        self.process = process
        self.err = err
        self.counts = [12, 4, 1]
        """How many services, publishers and subscriptions it has at least."""
        namespace, _, self.name = target.rpartition("/")
        self.namespace = namespace or "/"
        self.events: list[Any] = []
        self.parameter_events: list[Any] = []
        self.node: Any = rclpy.create_node(f"asker_{id(self)}", context=context)
        self.executor: Any = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self.node.create_subscription(
            TransitionEvent, f"{target}/transition_event", self.events.append, 100
        )
        self.node.create_subscription(ParameterEvent, "/parameter_events", self._keep_event, 100)

    def _keep_event(self, event: Any) -> None:
        if event.node == self.target:
            self.parameter_events.append(event)

    def connect(self) -> None:
        """Wait until both sides have found each other, or the node has ended.

        Raises:
            UndiscoveredError: They have not, as happens now and then on a busy machine.
        """
        client = self.node.create_client(GetState, f"{self.target}/get_state")
        self.await_true(lambda: self.has_ended or client.service_is_ready(), "a service")
        for _ in range(ATTEMPTS):
            # The first may be lost, where the server has not found the client yet.
            future = client.call_async(GetState.Request())
            self.executor.spin_until_future_complete(future, 1.0)
            if future.done() or self.has_ended:
                break
        # What a node has is told apart from what its topics are, and later.
        self.await_true(lambda: self.has_ended or self._is_in_graph(), "everything")

    @property
    def has_ended(self) -> bool:
        """Whether the node's process has ended."""
        return self.process.poll() is not None

    def _is_in_graph(self) -> bool:
        about, node = (self.name, self.namespace), self.node
        if about not in node.get_node_names_and_namespaces():
            return False
        try:
            found = (
                node.get_service_names_and_types_by_node(*about),
                node.get_publisher_names_and_types_by_node(*about),
                node.get_subscriber_names_and_types_by_node(*about),
            )
        except NodeNameNonExistentError:
            # It was the node before, which has just gone.
            return False
        ends = node.get_publishers_info_by_topic(f"{self.target}/transition_event")
        return bool(ends) and all(len(f) >= n for f, n in zip(found, self.counts, strict=True))

    def await_true(self, condition: Any, what: str) -> None:
        """Spin until something holds.

        Raises:
            UndiscoveredError: It does not hold in time. Only discovery takes that long.
        """

        def holds() -> bool:
            self.executor.spin_once(timeout_sec=0.02)
            return bool(condition())

        try:
            wait_until(holds, f"{what} of {self.target}")
        except AssertionError as error:
            raise UndiscoveredError(f"{error}; it wrote:\n{self.err.read_text()}") from error

    def _client(self, kind: Any, service: str) -> Any:
        name = f"{self.target}/{service}"
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, name)
            self.await_true(self._clients[name].service_is_ready, service)
        return self._clients[name]

    def start(self, kind: Any, service: str, **fields: Any) -> Any:
        """Send a request; return the future of the response."""
        return self._client(kind, service).call_async(kind.Request(**fields))

    def finish(self, future: Any) -> Any:
        """Return the response, when it is here."""
        self.await_true(future.done, "an answer")
        return future.result()

    def call(self, kind: Any, service: str, **fields: Any) -> Any:
        """Send a request and return the response."""
        return self.finish(self.start(kind, service, **fields))

    def destroy(self) -> None:
        """Give everything back."""
        self.executor.shutdown()
        self.node.destroy_node()


@contextmanager
def asked(
    context: Any, folder: Path, source: str, namespace: str, *arguments: str
) -> Iterator[Asker]:
    """Run a twin in a process of its own, with somebody to ask it."""
    file = folder / f"{namespace}.py"
    file.write_text(source)
    ros = ["--ros-args", "-r", f"__ns:=/{namespace}", *arguments]
    renamed = [
        word.partition(":=")[2].replace("-", "")
        for word in arguments
        if word.startswith("__node:=")
    ]
    err_file = folder / f"{namespace}.err"
    with err_file.open("w") as err:
        process = subprocess.Popen(
            [sys.executable, str(file), *ros], stdout=err, stderr=err, text=True
        )
        target = f"/{namespace}/{renamed[0] if renamed else 'arm'}"
        asker = Asker(context, target, process, err_file)
        try:
            asker.counts[0] -= "start_type_description_service:=false" in arguments
            asker.counts[1] -= "--disable-rosout-logs" in arguments
            asker.counts[2] += "use_sim_time:=true" in arguments
            asker.connect()
            yield asker
        finally:
            process.kill()
            process.wait()
            asker.destroy()


def brief(message: Any) -> Any:
    """Return a message as plain data, without the fields that are empty."""
    if hasattr(message, "get_fields_and_field_types"):
        fields = [
            (name, brief(getattr(message, name))) for name in message.get_fields_and_field_types()
        ]
        return {name: value for name, value in fields if value not in ("", 0, False, [], {})}
    if hasattr(message, "tolist"):
        return message.tolist()
    if isinstance(message, (list, tuple)):
        return [brief(item) for item in message]
    return message


def shown(answer: Any, namespace: str) -> str:
    """Return an answer as text, whichever of the two gave it."""
    return json.dumps(answer).replace(f"/{namespace}", "").strip('"')
