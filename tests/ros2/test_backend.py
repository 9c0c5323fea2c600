"""The backend on real rclpy: topics, timers, parameters, time and the end."""

import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, cast

import pytest
import rclpy
from hypothesis import HealthCheck, example, given, settings
from rclpy.exceptions import (
    InvalidHandle,
    InvalidNodeNameException,
    InvalidServiceNameException,
)
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Header as RosHeader
from std_msgs.msg import String as RosString

from rosbase import BaseHandlers, BaseManager, BaseNode, check_node_name
from rosbase.contracts.backend import BackendOptions
from rosbase.errors import BackendError
from rosbase.imu.outlet import VARYING
from rosbase.lifecycle import CallbackReturn, State
from rosbase.messages import Header, Imu, String, Time
from rosbase.parameters import ParameterSpec
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase_ros2.backend import Ros2Backend
from support.ros import Client, spin_until
from support.strategies import node_names
from support.waiting import wait_until

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


def publish_until(backend: Ros2Backend, publish: Callable[[], object], got: list[Any]) -> None:
    """Publishes again and again, because discovery takes its time."""
    timer = backend.create_timer(0.02, publish)
    spin_until(backend, lambda: got)
    backend.destroy_timer(timer)


def test_native_messages_and_those_of_rosbase_meet_on_one_topic(backend: Ros2Backend) -> None:
    native: list[RosString] = []
    converted: list[String] = []
    publisher = backend.create_publisher(RosString, "words", 10)
    backend.create_subscription(RosString, "words", native.append, 10)
    backend.create_subscription(String, "words", converted.append, 10)
    publish_until(backend, lambda: publisher.publish(RosString(data="hello")), native)
    spin_until(backend, lambda: converted)
    assert native[0].data == "hello"
    assert converted[0] == String("hello")


def test_a_profile_of_rclpy_is_taken_as_it_is(backend: Ros2Backend) -> None:
    profile = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    got: list[String] = []
    backend.create_publisher(String, "latched", profile).publish(String("early"))
    backend.create_subscription(String, "latched", got.append, profile)
    spin_until(backend, lambda: got)
    assert got == [String("early")]


def test_a_node_name_that_ros_refuses_is_an_error_in_one_line() -> None:
    with pytest.raises(BackendError, match="'not a name' is not a node name") as caught:
        Ros2Backend(BackendOptions("not a name"))
    assert "\n" not in str(caught.value)


@given(node_names)
@example("my-robot")
@example("a/b")
@example("größe")
@example("n" * 221)
@example("n" * 220)
@example("__")
@settings(
    max_examples=60,
    deadline=None,
    # The context is the same for all of them.
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_names_are_refused_that_ros_refuses(context: Any, name: str) -> None:
    """Whatever rclpy makes a node of, with its services, is a name, and nothing else."""
    try:
        check_node_name(name)
    except BackendError:
        is_name = False
    else:
        is_name = True
    node = None
    try:
        node = rclpy.create_node(name, context=context)
    except (InvalidNodeNameException, InvalidServiceNameException):
        pass
    finally:
        if node is not None:
            node.destroy_node()
    assert (node is not None) == is_name


def test_a_topic_of_another_type_is_refused_with_both_named_and_nothing_of_rcl_on_stderr(
    backend: Ros2Backend, capfd: pytest.CaptureFixture[str]
) -> None:
    backend.create_publisher(String, "words", 10)
    with pytest.raises(BackendError, match=r"'/words': it carries std_msgs\S+String.* sensor_msgs"):
        backend.create_subscription(Imu, "/words", print, 10)
    assert capfd.readouterr().err == ""


def test_a_message_of_a_class_with_the_same_name_is_told_apart(backend: Ros2Backend) -> None:
    words = backend.create_publisher(String, "words", 10)
    with pytest.raises(
        TypeError, match=r"takes rosbase\.messages\.std_msgs\.String, not std_msgs\."
    ):
        words.publish(RosString(data="hello"))


def test_a_time_or_a_header_of_ros_is_accepted_in_messages_of_rosbase_and_the_other_way_round(
    backend: Ros2Backend,
) -> None:
    now: Any = backend.clock.now()
    # Checked by the setter: the tests run with ROS_PYTHON_CHECK_FIELDS.
    ros = RosHeader(stamp=now.to_msg(), frame_id="a")
    got: list[Imu] = []
    backend.create_subscription(Imu, "imu", got.append, 10)
    samples = backend.create_publisher(Imu, "imu", 10)
    wanted = Imu(Header(now, "a"))
    for sent in (wanted, Imu(Header(now.to_msg(), "a")), Imu(cast("Any", ros))):
        got.clear()
        publish_until(backend, partial(samples.publish, sent), got)
        assert got[0] == wanted
    times: list[Time] = []
    backend.create_subscription(Time, "time", times.append, 10)
    clock = backend.create_publisher(Time, "time", 10)
    publish_until(backend, lambda: clock.publish(now), times)
    assert times[0] == now == Time(now.sec, now.nanosec)
    assert hash(times[0]) == hash(now)


def test_a_destroyed_publisher_and_subscription_are_gone_from_the_graph(
    backend: Ros2Backend,
) -> None:
    publisher = backend.create_publisher(String, "words", 10)
    subscription = backend.create_subscription(String, "words", print, 10)
    assert backend.node.count_publishers("/words") == 1
    backend.destroy_publisher(publisher)
    backend.destroy_subscription(subscription)
    spin_until(backend, lambda: backend.node.count_publishers("/words") == 0)
    spin_until(backend, lambda: backend.node.count_subscribers("/words") == 0)


def test_a_message_whose_publisher_another_thread_ends_meanwhile_is_no_error(
    backend: Ros2Backend,
) -> None:
    def end(message: object) -> RosString:
        backend.destroy_publisher(words)
        spin_until(backend, lambda: backend.node.count_publishers("/words") == 0)
        return RosString()

    def end_samples() -> Iterator[float]:
        backend.destroy_publisher(samples)
        spin_until(backend, lambda: backend.node.count_publishers("/imu/data") == 0)
        yield from (0.0, 0.0, 0.0, 1.0)

    words = backend.create_publisher(String, "words", 10)
    cast("Any", words)._encode = end
    words.publish(String("x"))
    samples = backend.create_publisher(Imu, "imu/data", 10)
    send: Any = backend.prepared_sender(samples, Imu(), VARYING)
    send(7, end_samples(), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_a_publisher_that_the_program_destroys_by_hand_is_an_error(backend: Ros2Backend) -> None:
    words = backend.create_publisher(String, "words", 10)
    backend.node.destroy_publisher(cast("Any", words).inner)
    with pytest.raises(InvalidHandle):
        words.publish(String("x"))


def test_declared_parameters_are_parameters_of_the_node(backend: Ros2Backend) -> None:
    backend.declare_parameter(ParameterSpec("rate", 100.0, "Hz", minimum=1.0, maximum=1000.0))
    described = backend.node.describe_parameter("rate")
    assert described.description == "Hz"
    assert backend.node.get_parameter("rate").value == 100.0


def test_what_is_set_from_outside_is_checked_and_seen(backend: Ros2Backend) -> None:
    backend.declare_parameter(ParameterSpec("rate", 100.0, minimum=1.0))
    backend.declare_parameter(ParameterSpec("axes", "xyz", choices=("xyz", "zyx")))

    def set_to(name: str, value: Any) -> Any:
        return backend.node.set_parameters([rclpy.Parameter(name, value=value)])[0]

    assert set_to("rate", 50).successful
    assert backend.get_parameter("rate").value == 50.0
    assert isinstance(backend.get_parameter("rate").value, float)
    for name, value in [("rate", 0.5), ("rate", "fast"), ("rate", float("nan")), ("axes", "abc")]:
        refused = set_to(name, value)
        assert not refused.successful
        assert refused.reason
    assert backend.get_parameter("rate").value == 50.0


def test_two_backends_and_the_programs_own_rclpy_live_in_one_process(backend: Ros2Backend) -> None:
    rclpy.init(args=[])
    try:
        node = rclpy.create_node("hand_written")
        other = Ros2Backend(BackendOptions("other"))
        got: list[String] = []
        other.create_subscription(String, "words", got.append, 10)
        by_hand = node.create_publisher(RosString, "words", 10)
        publish_until(other, lambda: by_hand.publish(RosString(data="x")), got)
        other.close()
        assert rclpy.ok()
        node.destroy_node()
    finally:
        rclpy.shutdown()


def test_a_manager_runs_on_it_unchanged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")

    class Talker(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.heard: list[String] = []
            self.publisher = self.create_publisher(String, "chatter")
            self.create_subscription(String, "chatter", self.heard.append)

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            talker = self.nodes["talker"]
            talker.publisher.publish(String(str(self.timestamp)))
            if talker.heard or self.timestamp > 1000:
                self.manager.request_stop()

    manager = BaseManager("app", {"talker": Talker}, handlers_class=Handlers, node_freq_hz=100)
    manager.start_main_loop_timer()
    assert manager.nodes["talker"].heard


def test_a_lifecycle_node_is_driven_by_the_ros_tools_and_its_callbacks_run_on_the_main_loop(
    backend: Ros2Backend, context: Any
) -> None:
    threads: list[threading.Thread] = []

    class Walker(LifecycleNode):
        def on_configure(self, previous_state: State) -> CallbackReturn:
            threads.append(threading.current_thread())
            return CallbackReturn.SUCCESS

    walker = Walker(backend=backend)
    client = Client(context, "test_node")
    walked: list[object] = []

    def walk() -> None:
        client.await_services()
        for label in ("configure", "activate", "configure", "shutdown"):
            walked.append(client.change(label=label))
            walked.append(client.state())
        client.destroy()

    thread = threading.Thread(target=walk)
    thread.start()
    spin_until(backend, lambda: not thread.is_alive())
    assert walked == [
        *(True, "inactive", True, "active"),
        *(False, "active", True, "finalized"),
    ]
    assert threads == [threading.current_thread()]
    assert walker.get_state() is State.FINALIZED


def test_only_the_first_lifecycle_node_is_exposed_and_the_next_says_so(
    backend: Ros2Backend, caplog: pytest.LogCaptureFixture
) -> None:
    LifecycleNode(backend=backend)
    LifecycleNode(backend=backend)
    names = [name for name, _ in backend.node.get_service_names_and_types()]
    assert names.count("/test_node/get_state") == 1
    (record,) = caplog.records
    assert record.name == "rosbase.test_node"
    assert "is not seen by the ROS tools" in record.message


ROS_ARGUMENTS = """
import sys
from rosbase.contracts.backend import BackendOptions
from rosbase.messages import String
from rosbase.parameters import ParameterSpec
from rosbase_ros2.backend import Ros2Backend
backend = Ros2Backend(BackendOptions("n"))
print(backend.declare_parameter(ParameterSpec("rate", 1.0)).value)
print(backend.create_publisher(String, "words", 10).topic, backend.node.get_fully_qualified_name())
backend.close()
"""


def run_with(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", ROS_ARGUMENTS, *arguments],
        check=False,
        capture_output=True,
        text=True,
        timeout=30,
    )


def test_ros_arguments_set_parameters_names_and_namespaces() -> None:
    done = run_with(
        *("--ros-args", "-p", "rate:=7", "-r", "words:=letters"),
        *("-r", "__ns:=/robot", "-r", "__node:=eve"),
    )
    assert done.stdout.splitlines() == ["7.0", "/robot/letters /robot/eve"], done.stderr


def test_what_stands_outside_of_ros_args_is_no_remapping_and_no_warning() -> None:
    done = run_with(
        *("-p", "words:=/dev/ttyUSB0", "--ros-args", "-r", "__node:=eve", "--", "words:=letters"),
        *("--ros-args", "-p", "rate:=7"),
    )
    assert (done.stdout.splitlines(), done.stderr) == (["7.0", "/words /eve"], "")


def test_a_parameter_file_is_read(tmp_path: Any) -> None:
    file = tmp_path / "params.yaml"
    file.write_text("n:\n  ros__parameters:\n    rate: 3.5\n")
    assert run_with("--ros-args", "--params-file", str(file)).stdout.splitlines()[0] == "3.5"


def test_a_wrong_ros_argument_is_one_line() -> None:
    done = run_with("--ros-args", "-p", "rate")
    assert "ROS 2 does not start" in done.stderr.splitlines()[-1]


def test_an_argument_that_ros_does_not_know_is_named_as_such() -> None:
    done = run_with("--ros-args", "--bogus")
    assert "not known behind --ros-args: ['--bogus']" in done.stderr.splitlines()[-1]


@pytest.mark.parametrize("example", ["pick_place", "quadruped"])
def test_the_examples_run_on_ros_without_a_changed_line(example: str) -> None:
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / example)],
        check=False,
        capture_output=True,
        text=True,
        timeout=50,
        env={**os.environ, "ROSBASE_BACKEND": "ros2"},
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout.count(" -> ") >= 7


@pytest.mark.parametrize("kind", [BaseNode, LifecycleNode])
def test_a_lone_node_whose_constructor_raises_leaves_the_graph(
    kind: type[BaseNode], context: Any
) -> None:
    watcher: Any = rclpy.create_node("watcher", context=context)

    class Broken(kind):  # type: ignore[misc,valid-type]  # the base is a parameter
        def __init__(self) -> None:
            super().__init__(backend="ros2", node_name="broken")
            self.create_publisher(String, "words", 1)
            wait_until(lambda: "broken" in watcher.get_node_names(), "the node")
            raise OSError("no device")

    try:
        with pytest.raises(OSError, match="no device"):
            Broken()
        wait_until(lambda: "broken" not in watcher.get_node_names(), "the graph without it")
        assert watcher.count_publishers("/words") == 0
    finally:
        watcher.destroy_node()
