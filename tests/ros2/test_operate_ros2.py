"""Commands on programs of the backend `ros2`, beside the same questions asked with rclpy."""

import os
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rclpy.parameter_client import AsyncParameterClient

from support.command import RunningRosbase
from support.operated import APP, LISTENER, Robots, pid_of, robots_in, run, run_both
from support.ros import TIMEOUT_S, Client
from support.waiting import wait_until

ROS = {"ROSBASE_BACKEND": "ros2"}
# As in pyproject.toml: lark, which rclpy imports, uses it.
OPTIONS = ("-W", "ignore:module 'sre_:DeprecationWarning")


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


@pytest.fixture
def outside(context: Any) -> Iterator[Client]:
    """A node of plain rclpy, with the clients of the lifecycle of /arm."""
    client = Client(context, "arm")
    yield client
    client.destroy()


def by_rclpy(node: Any, kind: str, names: tuple[str, ...]) -> set[tuple[str, str]]:
    """Names and types of the publishers, subscribers or services of nodes, as rclpy tells them."""
    ask = getattr(node, f"get_{kind}_names_and_types_by_node")
    known = {name for name, _ in node.get_node_names_and_namespaces()}
    return {(n, types[0]) for name in names if name in known for n, types in ask(name, "/")}


def lines_with_types(shown: str) -> set[tuple[str, str]]:
    """Names and types of a list with `-t`."""
    found = (line.partition(" ") for line in shown.splitlines())
    return {(name, kind.strip("[]")) for name, _, kind in found}


def section(shown: str, title: str) -> set[tuple[str, str]]:
    """Names and types of a part of `node info`."""
    part = shown.partition(f"  {title}:\n")[2].splitlines()
    found: set[tuple[str, str]] = set()
    for line in part:
        if not line.startswith("    "):
            break
        name, _, kind = line.strip().partition(": ")
        found.add((name, kind))
    return found


def test_the_graph_is_the_one_that_rclpy_tells(robots: Robots, outside: Client) -> None:
    robots.start(APP, env=ROS, options=OPTIONS)
    nodes = ("app", "arm")
    node = outside.node
    wait_until(lambda: len(by_rclpy(node, "service", nodes)) > 10, "discovery")
    topics = by_rclpy(node, "publisher", nodes) | by_rclpy(node, "subscriber", nodes)
    assert lines_with_types(run("topic", "list", "-t", "--all")) == topics
    shown = lines_with_types(run("service", "list", "-t", "--all"))
    assert shown == by_rclpy(node, "service", nodes)
    assert set(run("node", "list").split()) == {f"/{name}" for name in nodes}
    for name in nodes:
        info = run("node", "info", name)
        for title, kind in (
            ("Publishers", "publisher"),
            ("Subscribers", "subscriber"),
            ("Service Servers", "service"),
        ):
            assert section(info, title) == by_rclpy(node, kind, (name,)), title


def test_parameters_are_those_that_rclpy_reads_and_sets(robots: Robots, outside: Client) -> None:
    robots.start(APP, env=ROS, options=OPTIONS)
    client: Any = AsyncParameterClient(outside.node, "app")
    assert client.wait_for_services(TIMEOUT_S)
    run("param", "set", "app", "robot.speed", "0.25")
    answer = outside.finish(client.get_parameters(["robot.speed", "robot.names"]))
    assert answer.values[0].double_value == 0.25
    assert list(answer.values[1].string_array_value) == ["a", "b"]
    changed = rclpy.Parameter("robot.speed", value=0.75)
    outside.finish(client.set_parameters([changed.to_parameter_msg()]))
    assert run("param", "get", "app", "robot.speed") == "Double value is: 0.75\n"
    names = outside.finish(client.list_parameters([], 0)).result.names
    assert run("param", "list", "app").split() == sorted(names)


def test_what_dump_prints_is_what_load_and_programs_take(robots: Robots, tmp_path: Path) -> None:
    robots.start(APP, env=ROS, options=OPTIONS)
    run("param", "set", "app", "robot.speed", "0.25", "robot.names", "[x, 'on', '1']")
    text = run("param", "dump", "app")
    assert (
        "    robot:\n      names:\n      - x\n      - 'on'\n      - '1'\n      speed: 0.25\n"
        in text
    )
    assert text.startswith("/app:\n  ros__parameters:\n")
    file = tmp_path / "app.yaml"
    file.write_text(text)
    run("param", "set", "app", "robot.speed", "9", "robot.names", "[]")
    loaded = run_both("param", "load", "app", str(file))[0]
    assert "Set parameter robot.names successful\nSet parameter robot.speed successful\n" in loaded
    # One of rclpy's own.
    assert "Set parameter use_sim_time successful\n" in loaded
    assert run("param", "dump", "app") == text
    run("stop", "app")
    wait_until(lambda: run("node", "list") == "", "the end")
    # As a program of ROS takes it, and as one without ROS does.
    given = robots.start(APP, "--ros-args", "--params-file", str(file), env=ROS, options=OPTIONS)
    assert run("param", "get", "app", "robot.speed") == "Double value is: 0.25\n"
    assert run("param", "get", "app", "robot.names") == "String values are: ['x', 'on', '1']\n"
    given.process.terminate()
    given.end()
    source = tmp_path / "again.py"
    source.write_text(APP)
    again = robots.start_command("run", str(source), "--params-file", str(file))
    assert again.stdout is not None
    assert again.stdout.readline() == "ready\n"
    assert run("param", "get", "app", "robot.names") == "String values are: ['x', 'on', '1']\n"


def test_programs_of_two_domains_are_not_mixed(robots: Robots) -> None:
    domain = os.environ["ROS_DOMAIN_ID"]
    # A user's domain is from 0 to 101 on every system.
    other = str((int(domain) + 1) % 102)
    programs = {
        number: robots.start(APP, env={**ROS, "ROS_DOMAIN_ID": number}, options=OPTIONS)
        for number in sorted((domain, other))
    }
    refusal = run("topic", "echo", "/position", "--once", status=1)
    names = ", ".join(f"app [{pid_of(program)}]" for program in programs.values())
    assert f"/position is in 2 programs: {names}" in refusal
    for program in programs.values():
        chosen = ("--program", str(pid_of(program)))
        assert "x: " in run("topic", "echo", "/position", "--once", *chosen)
    shown = run("topic", "info", "/position")
    assert f"The programs are in different ROS domains: {', '.join(programs)}. Give" in shown


def test_every_transition_is_the_same_from_either_side(robots: Robots, outside: Client) -> None:
    robots.start(APP, env=ROS, options=OPTIONS)
    outside.await_services()
    for label in ("configure", "activate", "deactivate", "cleanup"):
        assert run("lifecycle", "set", "arm", label) == "Transitioning successful\n"
        state = outside.state()
        assert run("lifecycle", "get", "arm").split()[0] == state
        offered = outside.call("get_available_transitions").available_transitions
        labels = [one.transition.label for one in offered]
        shown = run("lifecycle", "list", "arm")
        assert [line[2:].split()[0] for line in shown.splitlines()[::3]] == labels
    assert not outside.change(label="activate")
    assert "activate" in run("lifecycle", "set", "arm", "activate", status=1)
    assert outside.change(label="shutdown")
    assert run("lifecycle", "get", "arm") == "finalized [4]\n"


def test_messages_are_heard_published_and_counted(robots: Robots) -> None:
    app = robots.start(APP, env=ROS, options=OPTIONS)
    shown = run("topic", "echo", "position", "--once")
    assert shown.startswith("x: ")
    assert shown.endswith("y: 0.0\nz: -1.0\n---\n")
    run("topic", "pub", "--once", "goal", "geometry_msgs/msg/Point", "{x: 2.5}")
    app.read_until("goal 2.5")
    assert "was off" in run("service", "call", "enable", "std_srvs/srv/SetBool", "{data: true}")
    assert "RuntimeError: no" in run("service", "call", "enable", "{data: false}", status=1)


def test_two_programs_on_ros_share_a_topic(robots: Robots) -> None:
    app = robots.start(APP, env=ROS, options=OPTIONS)
    listener = robots.start(LISTENER, env=ROS, options=OPTIONS)
    out, err = run_both("topic", "list")
    assert {"/goal", "/position"} <= set(out.split())
    assert err == ""
    info = run("topic", "info", "position")
    assert "Publisher count: 1\nSubscription count: 1\n" in info
    assert f"app [{pid_of(app)}], ros2: publishes (/app)\n" in info
    assert f"listener [{pid_of(listener)}], ros2: subscribes (/listener)\n" in info
    assert "Not connected" not in info
    assert run("topic", "echo", "position", "--once", "--field", "z") == "-1.0\n---\n"
    assert run("topic", "echo", "/position", "-P", "listener", "--once", "--field", "z").startswith(
        "-1.0"
    )


def test_the_reader_on_ros_is_looked_at_like_any_program(robots: Robots) -> None:
    with RunningRosbase("simulate") as device:
        device.waits_for("rosbase imu", where=device.out)
        line = next(line for line in device.out.lines if "rosbase imu" in line)
        command = [*shlex.split(line)[1:], "--backend", "ros2"]
        with RunningRosbase(*command) as reader:
            wait_until(lambda: "active [3]" in run_both("lifecycle", "get")[0], "the reader")
            assert run("topic", "echo", "imu/data", "--once").count("\n- ") == 27
            assert run("topic", "type", "imu/data") == "sensor_msgs/msg/Imu\n"
            assert "ros2" in run("ps")
            run("lifecycle", "set", "lifecycle_manager", "deactivate")
            assert run("lifecycle", "get") == "/lifecycle_manager: inactive [2]\n"
            run("stop", "lifecycle_manager")
            assert reader.end() == 0
