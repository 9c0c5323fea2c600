"""Parameters set by the tools of ROS: declared types stay, and the program may refuse."""

import threading
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from rcl_interfaces.msg import ParameterType
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter as RosParameter
from rclpy.parameter_client import AsyncParameterClient

from rosbase import (
    CallbackReturn,
    LifecycleNode,
    Parameter,
    ParameterKind,
    ParameterSpec,
    SetParametersResult,
    State,
)
from rosbase_ros2.backend import Ros2Backend
from support.ros import TIMEOUT_S, spin_until
from support.waiting import wait_until

Type = RosParameter.Type
SPECS = [
    ParameterSpec("stale_timeout", 1.0, minimum=0.001),
    ParameterSpec("select", [], kind=ParameterKind.STRING_ARRAY),
    ParameterSpec("gains", [1.0, 2.0]),
    ParameterSpec("ids", [1, 2]),
    ParameterSpec("flags", [True]),
    ParameterSpec("serial", "A1", read_only=True),
    ParameterSpec("frame_id", "imu_link"),
]


@pytest.fixture
def client(context: Any, backend: Ros2Backend) -> Iterator["Tool"]:
    for spec in SPECS:
        backend.declare_parameter(spec)
    tool = Tool(context)
    yield tool
    tool.close()


class Tool:
    """What `ros2 param set` does, on a node of its own."""

    def __init__(self, context: Any) -> None:
        self.node: Any = rclpy.create_node("tool", context=context)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.client = AsyncParameterClient(self.node, "test_node")
        wait_until(self.client.services_are_ready, "the parameter services")

    def set(self, name: str, kind: Any, value: Any) -> Any:
        future = self.client.set_parameters([RosParameter(name, kind, value)])
        self.executor.spin_until_future_complete(future, TIMEOUT_S)
        return future.result().results[0]

    def constraints_of(self, name: str) -> str:
        future = self.client.describe_parameters([name])
        self.executor.spin_until_future_complete(future, TIMEOUT_S)
        return str(future.result().descriptors[0].additional_constraints)

    def type_of(self, name: str) -> int:
        future = self.client.get_parameters([name])
        self.executor.spin_until_future_complete(future, TIMEOUT_S)
        return int(future.result().values[0].type)

    def close(self) -> None:
        self.executor.shutdown()
        self.node.destroy_node()


@pytest.mark.parametrize(
    ("name", "kind", "value", "expected", "ros_type"),
    [
        # What `ros2 param set` makes of `2`, `[]`, `[1, 2]` and `0`.
        ("stale_timeout", Type.INTEGER, 2, 2.0, ParameterType.PARAMETER_DOUBLE),
        ("select", Type.BOOL_ARRAY, [], [], ParameterType.PARAMETER_STRING_ARRAY),
        ("gains", Type.INTEGER_ARRAY, [1, 2], [1.0, 2.0], ParameterType.PARAMETER_DOUBLE_ARRAY),
        ("gains", Type.BYTE_ARRAY, [], [], ParameterType.PARAMETER_DOUBLE_ARRAY),
        ("ids", Type.INTEGER_ARRAY, [7], [7], ParameterType.PARAMETER_INTEGER_ARRAY),
        ("flags", Type.BOOL_ARRAY, [False], [False], ParameterType.PARAMETER_BOOL_ARRAY),
    ],
)
def test_what_is_set_from_outside_keeps_the_declared_type(
    name: str, kind: Any, value: Any, expected: Any, ros_type: int, client: Tool, backend: Any
) -> None:
    result = client.set(name, kind, value)
    assert result.successful, result.reason
    found = backend.get_parameter(name).value
    assert (found, type(found)) == (expected, type(expected))
    assert client.type_of(name) == ros_type


@pytest.mark.parametrize(
    ("name", "kind", "value", "said"),
    [
        ("stale_timeout", Type.STRING, "fast", "takes a number, not 'fast'"),
        ("stale_timeout", Type.DOUBLE, 0.0, "stale_timeout"),
        ("serial", Type.STRING, "B2", "read-only"),
        ("frame_id", Type.BOOL, False, "takes text, not False"),
        ("frame_id", Type.NOT_SET, None, "takes text, not None"),
        ("ids", Type.DOUBLE_ARRAY, [1.5], "takes whole numbers"),
    ],
)
def test_what_cannot_be_set_is_refused_with_the_reason(
    name: str, kind: Any, value: Any, said: str, client: Tool, backend: Any
) -> None:
    before = backend.get_parameter(name)
    result = client.set(name, kind, value)
    assert not result.successful
    assert said in result.reason
    assert backend.get_parameter(name) == before


def test_a_callback_of_the_program_is_asked_on_the_main_loop_and_may_refuse(
    client: Tool, backend: Ros2Backend
) -> None:
    asked: list[tuple[str, Any, int]] = []

    def judge(parameters: list[Parameter[Any]]) -> SetParametersResult:
        asked.extend((p.name, p.value, threading.get_ident()) for p in parameters)
        return SetParametersResult(parameters[0].value != "map", "the sensor has its frame")

    backend.add_on_set_parameters_callback(judge)
    results: list[Any] = []

    def ask() -> None:
        results.extend(client.set("frame_id", Type.STRING, value) for value in ("map", "imu_left"))

    tool = threading.Thread(target=ask)
    tool.start()
    spin_until(backend, lambda: len(results) == 2)
    tool.join()
    me = threading.get_ident()
    assert asked == [("frame_id", "map", me), ("frame_id", "imu_left", me)]
    assert [r.successful for r in results] == [False, True]
    assert results[0].reason == "the sensor has its frame"
    assert backend.get_parameter("frame_id").value == "imu_left"


@pytest.mark.parametrize(
    ("callback", "said"),
    [
        (lambda _: None, "must return a SetParametersResult, not None"),
        (lambda _: 1 / 0, "raised ZeroDivisionError: division by zero"),
    ],
)
def test_a_callback_that_fails_refuses_what_is_set_from_outside_and_ends_nothing(
    client: Tool, backend: Ros2Backend, callback: Any, said: str
) -> None:
    backend.add_on_set_parameters_callback(callback)
    results: list[Any] = []
    tool = threading.Thread(
        target=lambda: results.append(client.set("frame_id", Type.STRING, "map"))
    )
    tool.start()
    spin_until(backend, lambda: bool(results))
    tool.join()
    assert not results[0].successful
    assert said in results[0].reason
    assert backend.get_parameter("frame_id").value == "imu_link"


def test_a_main_loop_that_does_not_come_to_it_is_a_refusal_and_nothing_is_set_later(
    client: Tool, backend: Ros2Backend
) -> None:
    asked: list[list[Parameter[Any]]] = []
    backend.add_on_set_parameters_callback(
        lambda parameters: asked.append(parameters) or SetParametersResult(True)  # type: ignore[func-returns-value]  # `append` returns None
    )
    result = client.set("frame_id", Type.STRING, "late")
    assert not result.successful
    assert result.reason == "the main loop has not answered for 2 s"
    while backend.spin_once(0.0):
        pass
    assert asked == []
    assert backend.get_parameter("frame_id").value == "imu_link"


def test_a_parameter_says_in_which_state_it_may_change_and_keeps_to_it(
    context: Any, backend: Ros2Backend
) -> None:
    node = LifecycleNode(backend=backend)
    port = ParameterSpec("port", "a", choices=("a", "b"), change_time="unconfigured")
    node.declare_parameter(port.name, port.default, port)
    tool, answers = Tool(context), []
    assert tool.constraints_of("port") == "one of a, b; set it while unconfigured"

    def set_in(state: State, value: str) -> Any:
        assert node.get_state() is state
        thread = threading.Thread(
            target=lambda: answers.append(tool.set("port", Type.STRING, value))
        )
        thread.start()
        spin_until(backend, lambda: bool(answers))
        thread.join()
        return answers.pop()

    assert set_in(State.UNCONFIGURED, "b").successful
    node.trigger_configure()
    refused = set_in(State.INACTIVE, "a")
    assert not refused.successful
    assert refused.reason == (
        "parameter port cannot be set while inactive: set it while unconfigured"
    )
    assert set_in(State.INACTIVE, "b").successful
    assert node.get_parameter("port").value == "b"
    tool.close()


def test_while_the_main_loop_runs_a_transition_the_refusal_says_so_at_once(
    context: Any, backend: Ros2Backend
) -> None:
    answers: list[Any] = []
    answered = threading.Event()

    class Slow(LifecycleNode):
        def on_configure(self, previous_state: State) -> CallbackReturn:
            tool.start()
            answered.wait(TIMEOUT_S)
            return CallbackReturn.SUCCESS

    def ask() -> None:
        answers.append(client.set("port", Type.STRING, "b"))
        answered.set()

    node, client, tool = Slow(backend=backend), Tool(context), threading.Thread(target=ask)
    port = ParameterSpec("port", "a", change_time="unconfigured")
    node.declare_parameter(port.name, port.default, port)
    node.trigger_configure()
    tool.join()
    client.close()
    assert answers[0].reason.startswith("busy: configuring since ")
