"""`rosbase view --foxglove` of programs that run, with a client that knows the protocol only."""

import math
import os
import signal
import socket
import struct
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rosbase import SystemClock
from rosbase.control import connect
from rosbase.messages import Imu, Point, String
from rosbase.messages.std_srvs import SetBool
from rosbase.messages.tf2_msgs import TFMessage
from rosbase.wire import deserialize, schema, serialize
from rosbase.wire.plain import decoder
from support.command import RunningRosbase, run_rosbase
from support.foxglove_client import FoxgloveClient
from support.foxglove_served import BOARDS, served
from support.operated import APP, LISTENER, Robots, pid_of, robots_in
from support.waiting import wait_until

pytestmark = pytest.mark.timeout(120)


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


@pytest.fixture
def app(robots: Robots) -> int:
    return pid_of(robots.start(APP))


@pytest.fixture
def client(app: int) -> Iterator[FoxgloveClient]:
    with served("app") as (_, port), FoxgloveClient(port) as found:
        yield found


def test_a_client_gets_channels_and_messages(client: FoxgloveClient) -> None:
    channel = client.channel("/position")
    assert channel["encoding"] == "cdr"
    assert channel["schemaEncoding"] == "ros2msg"
    assert channel["schemaName"] == "geometry_msgs/msg/Point"
    before_ns = SystemClock.now_ns()
    client.subscribe("/position")
    client.until(lambda: len(client.of("/position")) >= 20, "messages")
    # Read with nothing but the schema.
    read = decoder(channel["schemaName"], channel["schema"])
    xs = [read(one.data)["x"] for one in client.of("/position")]
    assert xs == [xs[0] + 0.5 * number for number in range(len(xs))]
    stamps = [one.stamp_ns for one in client.of("/position")]
    assert stamps == sorted(stamps)
    assert stamps[-1] > before_ns


def test_parameters_are_read_written_and_told(client: FoxgloveClient) -> None:
    client.channel("/position")
    wait_until(lambda: "/app.robot.speed" in client.get_parameters(), "the parameters")
    assert client.get_parameters() == {"/app.robot.speed": 1.5, "/app.robot.names": ["a", "b"]}
    assert client.get_parameters("/app.robot.speed", "/nothing.x") == {"/app.robot.speed": 1.5}
    client.send("subscribeParameterUpdates", parameterNames=["/app.robot.speed"])
    # A whole number for a double, as JavaScript writes it.
    client.set_parameters({"name": "/app.robot.speed", "value": 2})
    client.until(lambda: client.parameters["/app.robot.speed"]["value"] == 2.0, "the value")
    assert client.parameters["/app.robot.speed"]["type"] == "float64"
    assert connect("app").get_parameters("robot")["speed"] == 2.0
    client.set_parameters({"name": "/app.robot.names", "value": ["c"]})
    wait_until(lambda: connect("app").get_parameters("robot")["names"] == ["c"], "the names")
    # One that somebody else sets.
    connect("app").set_parameters("robot", {"speed": 3.5})
    client.until(lambda: client.parameters["/app.robot.speed"]["value"] == 3.5, "the change")


def test_a_refused_parameter_keeps_its_value_and_the_reason_is_shown(
    client: FoxgloveClient,
) -> None:
    wait_until(lambda: "/app.robot.speed" in client.get_parameters(), "the parameters")
    answer = client.set_parameters({"name": "/app.robot.speed", "value": "fast"})
    assert answer == {"/app.robot.speed": 1.5}
    client.until(
        lambda: "takes a number, not 'fast'" in str(client.statuses.values()), "the reason"
    )
    client.set_parameters({"name": "/app.robot.speed", "value": 1.0})
    client.until(lambda: not client.statuses, "the end of the reason")


def test_services_are_called(client: FoxgloveClient) -> None:
    response = client.call("/enable", bytes(serialize(SetBool.Request(True))))
    assert isinstance(response, bytes)
    assert deserialize(response, SetBool.Response).message == "was off"
    failure = client.call("/enable", bytes(serialize(SetBool.Request(False))))
    # Without the name of a class of ours.
    assert str(failure).startswith("the call failed: /enable failed: RuntimeError: no")
    service = next(one for one in client.services.values() if one["name"] == "/enable")
    assert service["type"] == "std_srvs/srv/SetBool"
    assert service["request"]["schema"] == "bool data\n"
    # So a lifecycle node is driven as in ROS.
    assert "/arm/change_state" in [one["name"] for one in client.services.values()]


def test_a_client_publishes(robots: Robots) -> None:
    program = robots.start(APP)
    with served("app") as (_, port), FoxgloveClient(port) as client:
        client.channel("/goal")
        client.advertise("/goal", "geometry_msgs/msg/Point")
        for number in range(3):
            client.publish(bytes(serialize(Point(float(number), 0.0, 0.0))))
        program.read_until("goal 0.0")
        program.read_until("goal 1.0")
        program.read_until("goal 2.0")
        client.publish(b"no point")
        client.until(lambda: "/goal is not published" in str(client.statuses), "the reason")
        client.advertise("/gaol", "geometry_msgs/msg/Point", 2)
        client.publish(bytes(serialize(Point(1.0, 0.0, 0.0))), 2)
        client.until(lambda: "no program has /gaol" in str(client.statuses), "the notice")


def test_nodes_topics_and_services_are_a_graph(client: FoxgloveClient) -> None:
    client.send("subscribeConnectionGraph")
    client.until(lambda: client.published.get("/position") == ["/app"], "the publisher")
    assert client.subscribed["/goal"] == ["/app"]
    assert client.offered["/enable"] == ["/app"]
    assert client.offered["/arm/get_state"] == ["/arm"]


def test_the_time_of_the_machine_moves_on(client: FoxgloveClient) -> None:
    client.until(lambda: len(client.times) > 3, "the time")
    assert client.times == sorted(client.times)
    assert abs(client.times[-1] - SystemClock.now_ns()) < 10_000_000_000


def echoes(pid: int) -> int:
    """Connections of the program, without this one."""
    return int(connect(pid).processes()[0]["clients"]) - 1


def test_the_program_is_asked_for_messages_only_while_a_client_listens(robots: Robots) -> None:
    pid = pid_of(robots.start(APP))
    with served() as (_, port), FoxgloveClient(port) as client:
        client.channel("/position")
        wait_until(lambda: echoes(pid) == 0, "no stream")
        number = client.subscribe("/position")
        with FoxgloveClient(port) as other:
            other.subscribe("/position")
            other.until(lambda: other.messages, "messages")
            wait_until(lambda: echoes(pid) == 1, "one stream for both")
            client.unsubscribe(number)
        wait_until(lambda: echoes(pid) == 0, "the end of the stream")


def test_a_board_is_turned_in_the_world(robots: Robots) -> None:
    robots.start(BOARDS, "100", "1")
    with served("boards") as (_, port), FoxgloveClient(port) as client:
        channel = client.channel("/tf")
        assert channel["schemaName"] == "tf2_msgs/msg/TFMessage"
        assert channel["schema"] == schema(TFMessage)
        client.subscribe("/tf")
        client.until(lambda: len(client.of("/tf")) >= 5, "transforms")
        (found,) = deserialize(client.of("/tf")[-1].data, TFMessage).transforms
        assert (found.header.frame_id, found.child_frame_id) == ("world", "imu_link")
        assert found.transform.rotation.z == pytest.approx(math.sqrt(0.5))
        assert found.transform.rotation.w == pytest.approx(math.sqrt(0.5))


def test_each_client_gets_the_messages_that_a_program_keeps(robots: Robots) -> None:
    robots.start(BOARDS, "100", "1")
    with served("boards") as (_, port), FoxgloveClient(port) as first:
        first.subscribe("/model")
        first.until(lambda: first.of("/model"), "the kept message")
        with FoxgloveClient(port) as second:
            second.subscribe("/model")
            second.until(lambda: second.of("/model"), "the kept message again")
            data = second.of("/model")[0].data
            assert deserialize(data, String).data == "two boards"


def test_a_topic_without_a_type_of_ros_is_named_once(robots: Robots) -> None:
    robots.start(BOARDS, "100", "1")
    with served() as (view, port), FoxgloveClient(port) as client:
        client.channel("/imu/data")
        view.waits_for("/objects is not shown")
        count = len(client.times)
        client.until(lambda: len(client.times) > count + 50, "two more surveys")
        assert view.err.count("/objects is not shown") == 1
        assert "/objects" not in client.topics


def test_a_program_goes_and_comes_back_and_its_clients_stay(robots: Robots) -> None:
    first = robots.start(APP)
    with served("app") as (view, port), FoxgloveClient(port) as client:
        client.subscribe("/position")
        client.until(lambda: client.messages, "messages")
        client.channel("/goal")
        first.stop(signal.SIGINT)
        view.waits_for("program app has ended")
        client.until(lambda: client.topics == ["/position"], "channels without listeners to go")
        count = len(client.messages)
        robots.start(APP)
        view.waits_for("program app is back")
        client.until(lambda: len(client.messages) > count + 20, "messages again")
        client.channel("/goal")
        assert view.err.lines == [
            "rosbase view: program app has ended; waiting until it runs again",
            "rosbase view: program app is back",
        ]


def test_a_program_that_does_not_answer_keeps_all_that_it_offers(robots: Robots) -> None:
    pid = pid_of(robots.start(APP))
    with served("app") as (view, port), FoxgloveClient(port) as client:
        client.channel("/position")
        client.call("/enable", bytes(serialize(SetBool.Request(True))))
        wait_until(lambda: "/app.robot.speed" in client.get_parameters(), "the parameters")
        os.kill(pid, signal.SIGSTOP)
        try:
            view.waits_for(f"no answer from app [{pid}]")
            # It asks the program, and has no answer after a second.
            client.get_parameters()
            looks = len(client.times)
            client.until(lambda: len(client.times) > looks + 60, "three more looks")
            assert "/position" in client.topics
            assert "/enable" in [one["name"] for one in client.services.values()]
            assert "/app.robot.speed" in client.get_parameters()
        finally:
            os.kill(pid, signal.SIGCONT)
        view.waits_for("all programs answer again")


def test_all_programs_are_served_and_the_end_of_each_is_told(robots: Robots) -> None:
    first = robots.start(APP)
    pid = pid_of(first)
    with served() as (view, port), FoxgloveClient(port) as client:
        client.channel("/position")
        first.stop(signal.SIGINT)
        view.waits_for(f"app [{pid}] has ended")
        again = pid_of(robots.start(APP))
        view.waits_for(f"app [{again}] is back")


def test_topics_of_programs_that_do_not_hear_each_other_have_two_names(robots: Robots) -> None:
    robots.start(APP)
    robots.start(LISTENER)
    with served() as (_, port), FoxgloveClient(port) as client:
        wait_until(
            lambda: (
                {"/position", "/goal"} < set(client.topics)
                and {"/listener/position", "/app/position"} & set(client.topics)
            ),
            f"both, not {client.topics}",
        )


def test_programs_that_start_later_are_served(robots: Robots) -> None:
    with served() as (_, port), FoxgloveClient(port) as client:
        client.until(lambda: client.times, "the server")
        assert not client.topics
        robots.start(APP)
        client.subscribe("/position")
        client.until(lambda: client.messages, "messages")


def test_two_programs_of_one_name_have_services_and_parameters_of_their_own(
    robots: Robots,
) -> None:
    first, second = (pid_of(robots.start(APP)) for _ in range(2))
    with served() as (_, port), FoxgloveClient(port) as client:

        def services() -> set[str]:
            return {one["name"] for one in client.services.values()}

        client.until(lambda: {"/enable", "/app/enable"} <= services(), "both services")
        wait_until(lambda: len(client.get_parameters()) == 4, "the parameters of both")
        client.set_parameters({"name": "/app/app.robot.speed", "value": 3.0})
        wait_until(lambda: client.get_parameters()["/app/app.robot.speed"] == 3.0, "the value")
        assert client.get_parameters()["/app.robot.speed"] == 1.5
        speeds = [connect(pid).get_parameters("robot")["speed"] for pid in (first, second)]
        assert sorted(speeds) == [1.5, 3.0]


def test_a_client_that_goes_leaves_no_publisher_behind(robots: Robots) -> None:
    pid = pid_of(robots.start(APP))

    def publishers() -> int:
        topic = next(one for one in connect(pid).topics() if one["name"] == "/position")
        return len(topic["publishers"])

    with served("app") as (_, port):
        before = publishers()
        with FoxgloveClient(port) as client:
            client.channel("/position")
            client.advertise("/position", "geometry_msgs/msg/Point")
            client.publish(bytes(serialize(Point(1.0, 0.0, 0.0))))
            wait_until(lambda: publishers() == before + 1, "the publisher")
        wait_until(lambda: publishers() == before, "its end")


def numbers(client: FoxgloveClient) -> list[int]:
    """The Imus that a client has got, by their numbers."""
    stamps = [deserialize(one.data, Imu).header.stamp for one in client.of("/imu/data")]
    return [stamp.sec * 1_000 + stamp.nanosec for stamp in stamps]


def overruns_while(pid: int, condition: Callable[[], object], what: str) -> float:
    """Waits; gives the share of the ticks that were late meanwhile."""
    before = connect(pid).statistics()[0]
    wait_until(condition, what, 40.0)
    after = connect(pid).statistics()[0]
    return (after["overruns"] - before["overruns"]) / (after["ticks"] - before["ticks"])


def ticks_of(pid: int) -> int:
    return connect(pid).statistics()[0]["ticks"]


def usual_overruns(pid: int) -> float:
    """The share of late ticks without any client, on a machine that has other work."""
    first = ticks_of(pid)
    return overruns_while(pid, lambda: ticks_of(pid) > first + 200, "ticks")


# A tick that waited for a client would make all that follow late.
SOME = 0.2


def test_two_clients_of_which_one_never_reads(robots: Robots) -> None:
    # 6 MB, more than the buffers of a connection have.
    count = 20_000
    pid = pid_of(robots.start(BOARDS, "100", "20"))
    usual = usual_overruns(pid)
    with (
        served("boards") as (view, port),
        FoxgloveClient(port) as client,
        FoxgloveClient(port, reads=False) as lazy,
    ):
        lazy.subscribe("/imu/data", client.channel("/imu/data")["id"])
        client.subscribe("/imu/data")
        late = overruns_while(pid, lambda: len(client.messages) > count, "messages")
        assert late < usual + SOME
        found = numbers(client)
        assert found == list(range(found[0], found[0] + len(found)))
        view.waits_for("reads too slowly: it loses the oldest messages")
        assert view.err.count("reads too slowly") == 1
        lazy.read()
        lazy.until(lambda: numbers(lazy)[-1:] > found[-1:], "the newest messages")
        # The oldest that waited have made room.
        assert lazy.messages[0].stamp_ns < client.messages[1_000].stamp_ns
        assert len(numbers(lazy)) < numbers(lazy)[-1] - numbers(lazy)[0]


def test_a_server_that_is_suspended_does_not_delay_the_program(robots: Robots) -> None:
    pid = pid_of(robots.start(BOARDS, "100", "20"))
    usual = usual_overruns(pid)
    with served("boards") as (view, port), FoxgloveClient(port) as client:
        client.subscribe("/imu/data")
        client.until(lambda: client.messages, "messages")
        view.process.send_signal(signal.SIGSTOP)
        first = ticks_of(pid)
        late = overruns_while(pid, lambda: ticks_of(pid) > first + 500, "ticks")
        view.process.send_signal(signal.SIGCONT)
        assert late < usual + SOME
        last = client.messages[-1].stamp_ns
        client.until(lambda: client.messages[-1].stamp_ns > last, "messages again")


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_in_order(app: int, signum: int) -> None:
    with served("app") as (view, port), FoxgloveClient(port) as client:
        client.subscribe("/position")
        client.until(lambda: client.messages, "messages")
        assert view.end(signum) == 0
        client.until(lambda: client.is_closed, "the end of the connection")
        assert not view.err.lines
    wait_until(lambda: echoes(app) == 0, "no stream")


def one_line(*arguments: str) -> str:
    done = run_rosbase("view", *arguments)
    assert done.returncode in (1, 2), done
    assert not done.stdout
    assert done.stderr.count("\n") == 1, done.stderr
    return done.stderr


def test_a_port_in_use_is_one_line(robots: Robots) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert f"port {port} of 127.0.0.1 is in use" in one_line("--foxglove", str(port))


def test_a_wrong_name_and_a_wrong_port_are_one_line(app: int) -> None:
    assert "no program ap; did you mean app?" in one_line("--foxglove", "ap")
    assert "there is no port 99999" in one_line("--foxglove", "99999", "app")
    done = run_rosbase("view", "--foxglove", "0", "--host", "1.2.3.4")
    warning, reason = done.stderr.splitlines()
    assert "whoever reaches 1.2.3.4 can set parameters" in warning
    assert "cannot listen on port 0 of 1.2.3.4" in reason


def test_a_client_that_sends_rubbish_is_answered_and_the_others_go_on(
    client: FoxgloveClient,
) -> None:
    client.send("nonsense")
    client.until(lambda: client.statuses, "a complaint")
    client.subscribe("/position")
    client.until(lambda: client.messages, "messages")


def test_it_is_listening_on_this_machine_only(app: int) -> None:
    with served("app") as (view, port):
        assert isinstance(view, RunningRosbase)
        found = [
            line.split()[1]
            for table in ("tcp", "tcp6")
            for line in Path("/proc/net", table).read_text().splitlines()[1:]
            if int(line.split()[1].split(":")[1], 16) == port and line.split()[3] == "0A"
        ]
        assert [struct.pack("<I", int(one.split(":")[0], 16)) for one in found] == [
            socket.inet_aton("127.0.0.1")
        ]
