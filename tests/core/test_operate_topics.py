"""The commands for topics and services, against programs that run."""

import json
import os
import re
import signal
import subprocess
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from types import SimpleNamespace

import pytest

from rosbase.control import connect, time_limit
from rosbase.control.time_limit import TimeLimit
from rosbase.errors import ControlError
from support.command import ROSBASE
from support.operated import APP, LISTENER, Robots, pid_of, robots_in, run, run_both
from support.stopwatch import Stopwatch
from support.waiting import wait_until

PARENT = """
import sys
from rosbase import BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes
from rosbase.messages import Point


class Camera(BaseNode):
    def __init__(self, **kwargs):
        super().__init__(node_name="camera", **kwargs)
        out = self.create_publisher(Point, "seen")
        self.create_timer(0.01, lambda: out.publish(Point(1.0)))
        self.create_subscription(Point, "command", print)
        self.create_timer(0.1, lambda: self.logger.info("from the child"))


class Robot(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.heard = False
        self.create_subscription(Point, "seen", self.hear)
        self.out = self.create_publisher(Point, "command")

    def hear(self, message):
        if not self.heard:
            print("ready", flush=True)
        self.heard = True


class Handlers(BaseHandlers):
    def handle(self):
        self.node(Robot).out.publish(Point(2.0))


if __name__ == "__main__":
    processes = register_multiprocess_nodes({"camera": Camera})
    manager = BaseManager("parent", {"robot": Robot}, {}, Handlers, node_freq_hz=50)
    manager.start_main_loop_timer(processes)
"""
FAST = """
from rosbase import BaseNode
from rosbase.messages import Header, Imu, Time
from rosbase import SystemClock

count = 0
node = BaseNode(node_name="imu")
out = node.create_publisher(Imu, "imu/data")


def publish():
    global count
    count += 1
    stamp_ns = SystemClock().now_ns() - 20_000_000
    out.publish(Imu(header=Header(Time(*divmod(stamp_ns, 10**9)), "imu")))


node.create_timer(0.01, publish)
node.create_timer(0.2, lambda: print("ready", flush=True))
node.start_spin_standalone()
"""


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


def test_topics_as_ros2_lists_them(robots: Robots) -> None:
    robots.start(APP)
    assert run("topic", "list") == "/arm/transition_event\n/goal\n/position\n"
    assert run("topic", "list", "-t").splitlines()[2] == "/position [geometry_msgs/msg/Point]"
    assert run("topic", "list", "--count-topics") == "3\n"
    assert run("topic", "list", "-v") == (
        "Published topics:\n"
        " * /arm/transition_event [lifecycle_msgs/msg/TransitionEvent] 1 publisher\n"
        " * /position [geometry_msgs/msg/Point] 1 publisher\n\n"
        "Subscribed topics:\n * /goal [geometry_msgs/msg/Point] 1 subscriber\n\n"
    )
    assert run("topic", "type", "position") == "geometry_msgs/msg/Point\n"
    assert run("topic", "find", "geometry_msgs/Point") == "/goal\n/position\n"
    assert run("topic", "find", "geometry_msgs/msg/Point", "-c") == "2\n"
    assert run("topic", "find", "std_msgs/msg/String") == ""


def test_a_topic_is_described_as_by_ros2_and_by_program(robots: Robots) -> None:
    app = robots.start(APP)
    line = f"app [{pid_of(app)}], local: publishes (/app)\n"
    assert run("topic", "info", "position") == (
        f"Type: geometry_msgs/msg/Point\nPublisher count: 1\nSubscription count: 0\n\n{line}"
    )
    long = run("topic", "info", "/position", "--verbose")
    assert re.sub(r"RIHS01_\w+", "HASH", long) == (
        "Type: geometry_msgs/msg/Point\n\nPublisher count: 1\n\nNode name: app\n"
        "Node namespace: /\nTopic type: geometry_msgs/msg/Point\nTopic type hash: HASH\n"
        f"Endpoint type: PUBLISHER\nProcess: {pid_of(app)}\nQoS profile:\n"
        "  Reliability: RELIABLE\n  History (Depth): KEEP_LAST (10)\n  Durability: VOLATILE\n\n"
        f"Subscription count: 0\n\n{line}"
    )


def test_a_node_is_described_as_by_ros2(robots: Robots) -> None:
    robots.start(APP)
    shown = run("node", "info", "app")
    assert shown.startswith(
        "/app\n  Subscribers:\n    /goal: geometry_msgs/msg/Point\n"
        "  Publishers:\n    /position: geometry_msgs/msg/Point\n  Service Servers:\n"
    )
    assert "    /enable: std_srvs/srv/SetBool\n  Service Clients:\n" in shown


def test_messages_are_printed_as_yaml_json_and_csv(robots: Robots) -> None:
    robots.start(APP)
    assert re.fullmatch(
        r"x: \d+\.[05]\ny: 0\.0\nz: -1\.0\n---\n", run("topic", "echo", "position", "--once")
    )
    assert run("topic", "echo", "/position", "--once", "--field", "z") == "-1.0\n---\n"
    assert re.fullmatch(
        r"\d+\.[05],0\.0,-1\.0\n", run("topic", "echo", "position", "--csv", "--once")
    )
    one = json.loads(run("topic", "echo", "position", "--json", "--once"))
    assert (one["y"], one["z"]) == (0.0, -1.0)
    assert run("topic", "echo", "position", "--flow-style", "--once").startswith("{x: ")
    assert "not std_msgs/String" in run("topic", "echo", "position", "std_msgs/String", status=1)
    assert "no field w; there are: x, y, z" in run(
        "topic", "echo", "position", "--field", "w", status=1
    )
    assert "choose one" in run("topic", "echo", "position", "--json", "--csv", status=2)


def test_every_message_is_printed_in_order(robots: Robots) -> None:
    robots.start(APP)
    lines = run("topic", "echo", "position", "--csv", "--timeout", "1").splitlines()
    numbers = [float(line.split(",")[0]) * 2 for line in lines]
    assert len(numbers) > 20
    assert numbers == list(range(int(numbers[0]), int(numbers[0]) + len(numbers)))


def test_a_topic_on_which_nothing_comes_ends_with_status_1(robots: Robots) -> None:
    robots.start(APP)
    out, err = run_both("topic", "echo", "goal", "--timeout", "0.1", status=1)
    assert out == ""
    assert err == (
        "rosbase: no program publishes /goal yet\nrosbase: nothing was published on goal\n"
    )


def test_echo_ends_with_the_program(robots: Robots) -> None:
    app = robots.start(APP)
    echo = robots.start_command("topic", "echo", "position", "--csv")
    assert echo.stdout is not None
    assert echo.stdout.readline()
    app.process.terminate()
    echo.communicate(timeout=20)
    assert echo.returncode == 0
    assert app.end()[0] == 0


def test_a_stream_whose_program_is_killed_ends_with_status_1(robots: Robots) -> None:
    app = robots.start(APP)
    echo = robots.start_command("topic", "echo", "position", "--csv")
    hz = robots.start_command("topic", "hz", "position")
    for command in (echo, hz):
        assert command.stdout is not None
        assert command.stdout.readline()
    app.process.kill()
    for command in (echo, hz):
        _, err = command.communicate(timeout=20)
        assert (command.returncode, err) == (1, f"rosbase: process {pid_of(app)} has ended\n")
    app.process.wait()


def test_a_time_limit_ends_a_reader_that_is_slower_than_the_topic(robots: Robots) -> None:
    robots.start(APP)
    read = []
    for heard in islice(connect("app").echo("position", timeout_s=1.0), 10):
        read.append(heard)
        with Stopwatch() as watch:
            # At 100 Hz, there are messages that wait.
            wait_until(lambda: watch.took_s > 1.2, "the end of the time")
    assert len(read) == 1


def test_head_and_ctrl_c_end_echo_quietly(robots: Robots) -> None:
    robots.start(APP)
    done = subprocess.run(
        f"'{ROSBASE}' topic echo position | head -n 1; echo ${{PIPESTATUS[0]}}",
        shell=True,
        executable="/bin/bash",
        capture_output=True,
        text=True,
        timeout=40,
        check=False,
    )
    assert re.fullmatch(r"x: \d+\.[05]\n0\n", done.stdout)
    assert done.stderr == ""
    echo = robots.start_command("topic", "echo", "position")
    assert echo.stdout is not None
    assert echo.stdout.readline()
    echo.send_signal(signal.SIGINT)
    assert echo.communicate(timeout=20)[1] == ""
    assert echo.returncode == 130


def lines_of(robots: Robots, *words: str, count: int) -> list[str]:
    """The first lines that a command prints, which Ctrl-C then ends."""
    command = robots.start_command(*words)
    assert command.stdout is not None
    lines = [line.rstrip("\n") for line in islice(command.stdout, count)]
    command.send_signal(signal.SIGINT)
    _, err = command.communicate(timeout=20)
    assert (command.returncode, err) == (130, "")
    return lines


def test_rate_bandwidth_and_age_are_printed_as_by_ros2(robots: Robots) -> None:
    robots.start(FAST)
    rate = lines_of(robots, "topic", "hz", "imu/data", count=2)
    found = re.fullmatch(r"average rate: (\d+\.\d{3})", rate[0])
    assert found is not None
    assert 90.0 < float(found[1]) < 110.0
    assert re.fullmatch(
        r"\tmin: \d\.\d{3}s max: \d\.\d{3}s std dev: \d\.\d{5}s window: \d+", rate[1]
    )
    first, *bandwidth = lines_of(robots, "topic", "bw", "/imu/data", count=3)
    assert first == "Subscribed to [/imu/data]"
    assert re.fullmatch(r"\d\d\.\d\d KB/s from \d+ messages", bandwidth[0])
    assert re.fullmatch(r"\tMessage size mean: (0\.\d\d KB) min: \1 max: \1", bandwidth[1])
    age = lines_of(robots, "topic", "delay", "imu/data", count=2)
    found = re.fullmatch(r"average delay: (\d\.\d{3})", age[0])
    assert found is not None
    assert 0.02 <= float(found[1]) < 0.5


def test_a_field_may_be_an_element_of_a_list(robots: Robots) -> None:
    robots.start(FAST)
    field = "orientation_covariance"
    assert run("topic", "echo", "imu/data", "--once", "--field", f"{field}[8]") == "0.0\n---\n"
    words = ["topic", "echo", "imu/data", "--once", "--field"]
    assert "the list has 9 elements" in run(*words, f"{field}[9]", status=1)
    assert "[x] is no index" in run(*words, f"{field}[x]", status=1)


def test_a_message_without_a_header_has_no_age(robots: Robots) -> None:
    robots.start(APP)
    assert "has no header" in run("topic", "delay", "position", status=1)


def test_published_messages_arrive_in_the_program(robots: Robots) -> None:
    app = robots.start(APP)
    assert run("topic", "pub", "--once", "goal", "geometry_msgs/msg/Point", "{x: 2.5}") == (
        "publisher: beginning loop\npublishing #1: geometry_msgs.msg.Point(x=2.5, y=0.0, z=0.0)\n\n"
    )
    app.read_until("goal 2.5")
    shown = run("topic", "pub", "-t", "2", "-r", "50", "/goal", "geometry_msgs/Point", "x: 3")
    assert shown.count("publishing #") == 2
    app.read_until("goal 3.0")
    app.read_until("goal 3.0")


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        (["goal", "geometry_msgs/msg/Point", "{w: 1}"], 2, "has no field w"),
        (["goal", "geometry_msgs/msg/Point", "{x: far}"], 2, "Point.x takes float64, not 'far'"),
        (["goal", "geometry_msgs/msg/Point", "5"], 2, "the values are fields such as"),
        (["goal", "geometry_msgs/msg/Point", "{x"], 2, "character"),
        (["goal", "std_msgs/msg/String"], 1, "std_msgs/msg/String"),
        (["gaol", "std_msgs/msg/String"], 1, "no topic gaol; did you mean /goal?"),
        (["goal", "no_msgs/msg/Thing"], 1, "no_msgs/msg/Thing"),
        (["-1", "later", "geometry_msgs/msg/Point", "{w: 1}"], 2, "has no field w"),
        (["-1", "goal", "std_msgs/msg/String", "-w", "9"], 1, "not std_msgs/msg/String"),
        (["goal", "geometry_msgs/msg/Point", "--qos-reliability", "most"], 2, "is not one of"),
    ],
)
def test_what_cannot_be_published_is_explained(
    robots: Robots, words: list[str], status: int, text: str
) -> None:
    robots.start(APP)
    out, err = run_both("topic", "pub", *words, status=status)
    assert text in err
    assert "beginning loop" not in out


def test_a_type_that_no_program_knows_yet_is_told_before_pub_waits(robots: Robots) -> None:
    robots.start(APP)
    command = robots.start_command("topic", "pub", "-1", "later", "no_msgs/msg/Thing")
    assert command.stderr is not None
    assert "no_msgs/msg/Thing" in command.stderr.readline()
    command.send_signal(signal.SIGINT)
    command.communicate(timeout=20)
    assert command.returncode == 130


def test_a_rate_catches_up_after_a_delay(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [0.0]
    clock = SimpleNamespace(monotonic_ns=lambda: int(now_s[0] * 1e9))
    monkeypatch.setattr(time_limit, "time", clock)
    limit = TimeLimit(0.0)
    now_s[0] = 0.5
    for _ in range(5):
        limit.restart(0.1, behind_s=1.0)
        assert limit.is_over
    limit.restart(0.1, behind_s=1.0)
    assert limit.left_s == pytest.approx(0.1)
    now_s[0] = 5.0
    # At most what a second has room for, and now the next one.
    for _ in range(11):
        limit.restart(0.1, behind_s=1.0)
        assert limit.is_over
    limit.restart(0.1, behind_s=1.0)
    assert not limit.is_over


def test_pub_waits_for_a_subscription(robots: Robots) -> None:
    command = robots.start_command(
        "topic", "pub", "--once", "goal", "geometry_msgs/msg/Point", "{x: 1}"
    )
    assert command.stdout is not None
    assert command.stdout.readline() == "Waiting for at least 1 matching subscription(s)...\n"
    # It may come before the line that the program prints when it has begun.
    robots.start(APP, until="goal 1.0")
    assert command.communicate(timeout=20)[1] == ""
    assert command.returncode == 0


def test_services_are_listed_and_called_as_with_ros2(robots: Robots) -> None:
    robots.start(APP)
    assert "/enable [std_srvs/srv/SetBool]" in run("service", "list", "-t").splitlines()
    assert run("service", "type", "enable") == "std_srvs/srv/SetBool\n"
    expected = (
        "requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\n"
        "response:\nstd_srvs.srv.SetBool_Response(success=True, message='was off')\n\n"
    )
    assert run("service", "call", "/enable", "std_srvs/srv/SetBool", "{data: true}") == expected
    assert run("service", "call", "enable", "{data: True}") == expected
    assert "SetBool_Request(data=False)" in run_both("service", "call", "enable", status=1)[0]


@pytest.mark.parametrize(
    ("words", "status", "text"),
    [
        (["enable", "{data: false}"], 1, "/enable failed: RuntimeError: no"),
        (["enabl", "{data: true}"], 1, "no service enabl; did you mean /enable?"),
        (
            ["enable", "std_srvs/Trigger"],
            1,
            "is of type std_srvs/srv/SetBool, not std_srvs/Trigger",
        ),
        (["enable", "{date: 1}"], 2, "did you mean data?"),
    ],
)
def test_a_call_that_fails_is_told_with_status_1(
    robots: Robots, words: list[str], status: int, text: str
) -> None:
    robots.start(APP)
    assert text in run_both("service", "call", *words, status=status)[1]


def test_a_topic_of_two_programs_is_two_topics(robots: Robots) -> None:
    first, second = robots.start(APP), robots.start(APP)
    labels = [f"app [{pid}]" for pid in sorted([pid_of(first), pid_of(second)])]
    err = run("topic", "echo", "position", "--once", status=1)
    assert f"topic /position is in 2 programs: {', '.join(labels)}; choose one" in err
    assert "choose one" in run("topic", "hz", "position", status=1)
    assert "choose one" in run("topic", "pub", "goal", "geometry_msgs/msg/Point", status=1)
    pid = str(pid_of(first))
    assert run("topic", "echo", "position", "--once", "-P", pid, "--field", "y") == "0.0\n---\n"
    out, err = run_both("topic", "list")
    assert out == "/arm/transition_event\n/goal\n/position\n"
    assert err == (
        f"rosbase: not the same topic in each of {', '.join(labels)}: "
        "/arm/transition_event, /goal, /position\n"
    )


def test_who_does_not_hear_whom_is_shown(robots: Robots) -> None:
    app, listener = robots.start(APP), robots.start(LISTENER)
    first, second = f"app [{pid_of(app)}]", f"listener [{pid_of(listener)}]"
    shown = run("topic", "info", "position")
    assert f"{first}, local: publishes (/app)\n" in shown
    assert f"{second}, local: subscribes (/listener)\n" in shown
    assert f"Not connected: {second} does not hear {first}\n" in shown
    assert "ROSBASE_BACKEND=ros2" in shown
    # Only one of them publishes, so there is no doubt which one is meant.
    assert run("topic", "echo", "position", "--once", "--field", "y") == "0.0\n---\n"


def test_a_subscription_that_hears_nothing_of_another_program_is_told_so_once(
    robots: Robots,
) -> None:
    app, listener = robots.start(APP), robots.start(LISTENER)
    wait_until(lambda: "nothing comes on" in run("log", "-P", "listener"), "the warning", 30)
    records = run("log", "-P", "listener", "--level", "warn").splitlines()
    assert len(records) == 1
    assert (
        "nothing comes on /position: no node of this program publishes it, and app " in records[0]
    )
    assert f"[{pid_of(app)}], which does, is another program." in records[0]
    assert "ROSBASE_BACKEND=ros2" in records[0]
    assert "nothing comes on" not in run("log", "-P", "app")
    assert "/goal" not in records[0]
    listener.process.terminate()
    listener.end()


def test_a_child_process_is_on_the_bus_of_its_manager(robots: Robots) -> None:
    robots.start(PARENT)
    assert set(run("node", "list").split()) == {"/camera", "/parent"}
    out, err = run_both("topic", "list")
    assert (out, err) == ("/command\n/seen\n", "")
    assert "Not connected" not in run("topic", "info", "seen")
    assert run("topic", "echo", "seen", "--once", "--field", "x") == "1.0\n---\n"
    assert run("topic", "echo", "command", "--once", "--field", "x") == "2.0\n---\n"
    wait_until(lambda: "from the child" in run("log"), "a record of the child")
    assert "camera: from the child" not in run("log")
    rows = run("ps").splitlines()[1:]
    assert {row.split()[1] for row in rows} == {"parent", "camera"}
    run("stop", "parent")
    wait_until(lambda: run("node", "list") == "", "the end of both")


def test_the_python_api_hears_publishes_and_calls(robots: Robots) -> None:
    app = robots.start(APP)
    fleet = connect("app")
    assert [t["name"] for t in fleet.topics()] == ["/arm/transition_event", "/goal", "/position"]
    heard = list(islice(fleet.echo("position"), 3))
    numbers = [one.message["x"] * 2 for one in heard]
    assert numbers == [numbers[0], numbers[0] + 1, numbers[0] + 2]
    assert heard[0].type == "geometry_msgs/msg/Point"
    assert heard[0].pid == pid_of(app)
    assert heard[0].stamp_ns <= heard[1].stamp_ns
    assert list(fleet.echo("goal", timeout_s=0.05)) == []
    report = next(fleet.count("position", every_s=0.2))
    assert report["n"] == report["window"]["count"] > 5
    with fleet.publisher("goal") as goal:
        assert goal.publish({"x": 4.0}) == 1
        assert goal.publish() == 1
    app.read_until("goal 4.0")
    app.read_until("goal 0.0")
    assert fleet.call("enable", {"data": True}) == {"success": True, "message": "was off"}
    with pytest.raises(ControlError, match="RuntimeError: no"):
        fleet.call("enable")
    with pytest.raises(ValueError, match="has no field w"):
        fleet.call("enable", {"w": 1})
    assert {s["name"] for s in fleet.services()} >= {"/enable", "/arm/change_state"}
    assert fleet.node("app")["publishers"] == [
        {"name": "/position", "type": "geometry_msgs/msg/Point"}
    ]


def test_after_a_command_the_program_has_no_client_left(robots: Robots) -> None:
    app = robots.start(APP)
    fds = Path(f"/proc/{pid_of(app)}/fd")
    run("topic", "list")
    wait_until(lambda: len(os.listdir(fds)) < 20, "few descriptors")
    before = len(os.listdir(fds))
    for _ in range(5):
        run("topic", "echo", "position", "--once")
    wait_until(lambda: len(os.listdir(fds)) <= before, "the end of connections")
