"""A control socket of a program on ROS 2 answers as rclpy does, and as on `local`."""

import os
from collections.abc import Callable
from typing import Any

import pytest
from rclpy.parameter import parameter_value_to_python

from rosbase import (
    BaseManager,
    BaseNode,
    CallbackReturn,
    LifecycleNode,
    ParameterKind,
    ParameterSpec,
    State,
)
from support.control import Asker, ask_while_running
from support.ros import Client, ParameterTool


class Camera(LifecycleNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.declare_parameter("fps", 30, ParameterSpec("", 0, "frames", minimum=1, maximum=60))
        self.declare_parameter("gain", 0.5, ParameterSpec("", 0.0, minimum=0.0))
        self.declare_parameter("mode", "auto", ParameterSpec("", "", choices=("auto", "off")))
        self.declare_parameter("device", "a", ParameterSpec("", "", change_time="unconfigured"))
        self.declare_parameter("serial", "B2", ParameterSpec("", "", read_only=True))
        self.declare_parameter("octets", [b"a", b"\xff"])
        self.declare_parameter("none", [], ParameterSpec("", [], kind=ParameterKind.DOUBLE_ARRAY))

    def on_deactivate(self, previous_state: State) -> CallbackReturn:
        return CallbackReturn.FAILURE if self.get_parameter("fps").value == 7 else SUCCESS


class Robot(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.declare_parameter("speed", 1.5)


SUCCESS = CallbackReturn.SUCCESS
PUBLIC = ("configure", "activate", "deactivate", "cleanup", "shutdown", "destroy", "fly")
TYPES = ["not_set", *(kind.name.lower() for kind in ParameterKind)]


def run(questions: Callable[[Asker], None], backend: str = "ros2") -> None:
    nodes = {"camera": Camera, "robot": Robot}
    manager = BaseManager("app", nodes, node_freq_hz=50, backend=backend)
    ask_while_running(manager, questions)


def plain(value: Any) -> Any:
    """A value of rclpy's as the socket has it."""
    found = parameter_value_to_python(value)
    if isinstance(found, (str, bool, int, float)) or found is None:
        return found
    return [item[0] if isinstance(item, bytes) else item for item in found]


@pytest.mark.parametrize("node", ["camera", "app"])
def test_parameters_are_those_that_rclpy_sees(context: Any, node: str) -> None:
    def questions(client: Asker) -> None:
        tool = ParameterTool(context, node)
        try:
            names = list(tool.finish(tool._client.list_parameters()).result.names)
            values = {
                name: plain(value) for name, value in zip(names, tool.get(*names), strict=True)
            }
            described = tool.finish(tool._client.describe_parameters(names))
        finally:
            tool.destroy()
        assert "use_sim_time" in names
        listed = client.ask("parameter.list", node=node)["nodes"]
        assert sorted(listed[f"/{node}"]) == sorted(names)
        assert listed[f"/{node}"] == client.ask("parameter.list")["nodes"][f"/{node}"]
        found = client.ask("parameter.get", node=node)["values"]
        assert {name: one["value"] for name, one in found.items()} == values
        ours = client.ask("parameter.describe", node=node)["descriptors"]
        for name, theirs in zip(names, described.descriptors, strict=True):
            one = ours[name]
            assert one["type"] == found[name]["type"] == TYPES[theirs.type]
            assert one["description"] == theirs.description
            assert one["constraints"] == theirs.additional_constraints
            assert one["read_only"] == theirs.read_only
            ranges = [*theirs.integer_range, *theirs.floating_point_range]
            assert one["range"] == ([ranges[0].from_value, ranges[0].to_value] if ranges else None)

    run(questions)


def test_parameters_are_set_as_by_rclpy_with_the_same_reasons(context: Any) -> None:
    texts = [
        *(("fps", text) for text in ("25", "61", "many", "2.5")),
        *(("gain", text) for text in ("2", "-1", "0.25")),
        *(("mode", text) for text in ("off", "on")),
        *(("serial", "C3"), ("none", "[1, 2]"), ("none", "[]")),
    ]

    def questions(client: Asker) -> None:
        tool = ParameterTool(context, "camera")
        try:
            for name, text in texts:
                before = plain(tool.get(name)[0])
                theirs = tool.set(name, text)
                value = plain(tool.get(name)[0])
                restored = client.ask("parameter.set", node="camera", values={name: before})
                assert restored["results"][name]["successful"] or name == "serial"
                found = client.ask("parameter.set", node="camera", values={name: {"text": text}})
                ours = found["results"][name]
                assert ours["successful"] == theirs.successful, (name, text)
                assert (ours["reason"] == "") == (theirs.reason == "")
                assert plain(tool.get(name)[0]) == value
        finally:
            tool.destroy()

    run(questions)


def test_a_parameter_that_rosbase_has_not_declared_is_read(context: Any) -> None:
    def questions(client: Asker) -> None:
        found = client.ask("parameter.get", node="app", names=["use_sim_time"])["values"]
        assert found == {"use_sim_time": {"type": "bool", "value": False}}
        assert client.ask("parameter.get", node="robot")["values"] == {
            "speed": {"type": "double", "value": 1.5}
        }
        answer = client.answer("parameter.get", node="app", names=["use_sim_tim"])
        assert answer["suggestions"] == ["use_sim_time"]

    run(questions)


def walk(change: Callable[[str], tuple[bool, str]]) -> list[tuple[str, bool, str]]:
    """Asks for every transition in every state; gives what became of each."""
    found = []
    ways = [["configure", "cleanup"], ["configure", "activate", "deactivate"], ["activate"]]
    wrong = [label for label in PUBLIC if label != "shutdown"]
    for label in [*ways[0], *wrong, *ways[1], *wrong, *ways[2], *wrong, "shutdown", *PUBLIC]:
        found.append((label, *change(label)))
    return found


def by_socket(client: Asker) -> Callable[[str], tuple[bool, str]]:
    def change(label: str) -> tuple[bool, str]:
        answer = client.answer("lifecycle.set", node="camera", transition=label)
        assert "ok" in answer or answer["kind"] == "refused", answer
        is_done = "ok" in answer and answer["ok"]["successful"]
        state = client.ask("lifecycle.get", node="camera")["state"]
        return bool(is_done), str(state)

    return change


def test_all_transitions_the_wrong_ones_too_end_as_by_services_of_ros(context: Any) -> None:
    walks: dict[str, list[tuple[str, bool, str]]] = {}

    def by_services(_: Asker) -> None:
        other = Client(context, "camera")
        try:
            other.await_services()
            assert other.state() == "unconfigured"
            walks["services"] = walk(lambda label: (other.change(label=label), other.state()))
        finally:
            other.destroy()

    run(by_services)
    run(lambda client: walks.update(socket=walk(by_socket(client))))
    run(lambda client: walks.update(local=walk(by_socket(client))), "local")
    assert walks["services"] == walks["socket"] == walks["local"]
    assert {state for _, _, state in walks["local"]} == {
        "unconfigured",
        "inactive",
        "active",
        "finalized",
    }
    assert {done for _, done, _ in walks["local"]} == {True, False}


def test_a_failure_of_a_callback_is_the_same(context: Any) -> None:
    def questions(client: Asker) -> None:
        change = by_socket(client)
        assert change("configure") == (True, "inactive")
        assert change("activate") == (True, "active")
        client.ask("parameter.set", node="camera", values={"fps": 7})
        other = Client(context, "camera")
        try:
            other.await_services()
            assert other.state() == "active"
            assert (other.change(label="deactivate"), other.state()) == (False, "active")
        finally:
            other.destroy()
        answer = client.ask("lifecycle.set", node="camera", transition="deactivate")
        assert (answer["successful"], answer["result"]) == (False, "failure")
        assert answer["state"] == "active"

    run(questions)


def test_the_process_and_its_nodes_are_told_as_on_local() -> None:
    def questions(client: Asker) -> None:
        (program,) = client.ask("process")["programs"]
        assert (program["backend"], program["name"]) == ("ros2", "/app")
        assert program["network"] == os.environ["ROS_DOMAIN_ID"]
        assert program["nodes"] == ["/app", "/camera"]
        listed = client.ask("node.list")["nodes"]
        assert [(one["name"], one["key"]) for one in listed] == [
            ("/app", ""),
            ("/camera", "camera"),
            ("/app", "robot"),
        ]

    run(questions)
