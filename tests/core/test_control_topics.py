"""Topics and services over the control socket: what is told, heard, counted, published, called."""

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from attrs import frozen

from rosbase import BaseHandlers, BaseManager, BaseNode, LifecycleNode, LocalBackend
from rosbase.contracts.backend import BackendOptions
from rosbase.control.answers.backlog import MOST_BYTES
from rosbase.control.answers.topic_count import TopicCount
from rosbase.control.answers.topic_counts import TopicCounts
from rosbase.control.answers.topic_echo import TopicEcho
from rosbase.local import Bus
from rosbase.messages import (
    DiagnosticArray,
    DiagnosticStatus,
    Header,
    Image,
    Imu,
    String,
    Time,
    Vector3,
)
from rosbase.messages.fields import UInt8, message
from rosbase.messages.std_srvs import SetBool, Trigger
from rosbase.qos import DurabilityPolicy, QoSProfile
from rosbase.wire import deserialize, schema, serialize, type_hash
from rosbase.wire.plain import decoder, encoder
from support.control import Asker, ask_while_running, connected, own_socket
from support.program import running
from support.services import Double
from support.waiting import wait_until

LATCHED = QoSProfile(2, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@message("my_msgs/msg/Grip")
@frozen
class Grip:
    width: float = 0.5
    finger: UInt8 = 1


class Robot(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.imu = self.create_publisher(Imu, "imu/data", 5)
        self.grip = self.create_publisher(Grip, "grip", LATCHED)
        self.heard: list[Any] = []
        self.create_subscription(String, "words", self.heard.append, 3)
        self.create_subscription(Imu, "imu/data", self.heard.append, 3)
        self.create_service(SetBool, "switch", self.switch)
        self.create_service(Double, "double", lambda request: Double.Response(2))
        self.create_client(Trigger, "elsewhere")

    def switch(self, request: Any) -> Any:
        if not request.data:
            raise RuntimeError("stuck")
        return SetBool.Response(success=True, message="on")


class Camera(LifecycleNode):
    autostart = "activate"

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.image = self.create_publisher(DiagnosticArray, "~/image", 1)


class Handlers(BaseHandlers):
    def handle(self) -> None:
        pass


@pytest.fixture
def app() -> BaseManager:
    nodes = {"robot": Robot, "camera": Camera}
    return BaseManager("app", nodes, {}, Handlers, node_freq_hz=100)


def robot(app: BaseManager) -> Robot:
    return app.node(Robot)


def ask(app: BaseManager, questions: Callable[[Asker], None]) -> None:
    ask_while_running(app, questions)


def event(client: Asker, number: int) -> tuple[dict[str, Any], bytes]:
    """The next event of a stream."""
    frame, data = client.read()
    assert (frame["id"], "event" in frame) == (number, True), frame
    return frame["event"], data


@contextmanager
def streaming(client: Asker, what: str, **arguments: Any) -> Iterator[tuple[int, dict[str, Any]]]:
    """The number of a stream, and its answer."""
    number = client.send(what, **arguments)
    frame, _ = client.read()
    assert "ok" in frame, frame
    yield number, frame["ok"]


def end(client: Asker, number: int) -> None:
    """Ends a stream, and reads what was on its way."""
    cancel = client.send("cancel", of=number)
    while True:
        frame, _ = client.read()
        if frame.get("end"):
            return
        assert frame["id"] in (cancel, number)


# What there is.


def test_the_topics_are_listed_with_their_ends(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        topics = {topic["name"]: topic for topic in client.ask("topic.list")["topics"]}
        assert [*topics] == sorted(topics)
        assert topics["/imu/data"] == {
            "name": "/imu/data",
            "type": "sensor_msgs/msg/Imu",
            "publishers": [
                {
                    "node": "/app",
                    "qos": {
                        "reliability": "reliable",
                        "durability": "volatile",
                        "history": "keep_last",
                        "depth": 5,
                    },
                }
            ],
            "subscriptions": [
                {
                    "node": "/app",
                    "qos": {
                        "reliability": "reliable",
                        "durability": "volatile",
                        "history": "keep_last",
                        "depth": 3,
                    },
                    "dropped": 0,
                }
            ],
        }
        assert topics["/grip"]["publishers"][0]["qos"]["durability"] == "transient_local"
        assert topics["/camera/image"]["publishers"][0]["node"] == "/camera"
        assert topics["/camera/transition_event"]["type"] == "lifecycle_msgs/msg/TransitionEvent"

    ask(app, questions)


def test_a_node_is_told_with_its_ends(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        found = client.ask("node.info", name="camera")
        assert {"name": "/camera/image", "type": "diagnostic_msgs/msg/DiagnosticArray"} in found[
            "publishers"
        ]
        assert {
            "name": "/camera/change_state",
            "type": "lifecycle_msgs/srv/ChangeState",
        } in found["services"]
        own = client.ask("node.info", name="/app")
        assert {"name": "/words", "type": "std_msgs/msg/String"} in own["subscriptions"]
        assert own["clients"] == [{"name": "/elsewhere", "type": "std_srvs/srv/Trigger"}]

    ask(app, questions)


def test_a_type_is_told_by_its_topic_or_by_its_name(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        told = client.ask("topic.type", topic="imu/data")
        assert told == {
            "type": "sensor_msgs/msg/Imu",
            "encoding": "cdr",
            "schema_encoding": "ros2msg",
            "schema": schema(Imu, with_defaults=True),
            "hash": type_hash(Imu),
        }
        assert client.ask("topic.type", type="sensor_msgs/msg/Imu") == told
        # One of the program, and one that nobody uses.
        assert client.ask("topic.type", type="my_msgs/msg/Grip")["hash"] == type_hash(Grip)
        assert client.ask("topic.type", topic="/grip")["schema"].startswith("float64 width 0.5\n")
        assert client.ask("topic.type", type="nav_msgs/msg/Odometry")["schema"]
        # One of which there is no publisher until somebody listens.
        assert client.ask("topic.type", topic="/camera/transition_event")["schema"]

    ask(app, questions)


@pytest.mark.parametrize(
    ("ask_for", "arguments", "kind", "text", "suggestions"),
    [
        ("topic.type", {"topic": "imu/dat"}, "unknown", "no topic 'imu/dat'", ["/imu/data"]),
        ("topic.echo", {"topic": "imu"}, "unknown", "there is no topic 'imu'", None),
        ("topic.type", {"type": "my_msgs/msg/No"}, "unknown", "there is no type", None),
        ("topic.type", {"type": "os/path/join"}, "unknown", "there is no type", None),
        ("topic.type", {}, "invalid", "topic.type needs type, a text", None),
        ("topic.count", {"topic": "grip", "with": ["delay"]}, "invalid", "has no header", None),
        ("topic.count", {"topic": "grip", "with": ["x"]}, "invalid", "with has no 'x'", None),
        ("topic.count", {"topic": "grip", "every_ns": 1}, "invalid", "every_ns is at least", None),
        ("topic.publish", {"topic": "new"}, "unknown", "there is no topic 'new'", None),
        ("topic.publish", {"topic": "a b", "type": "my_msgs/msg/Grip"}, "invalid", "a b", None),
        ("topic.publish", {"topic": "grip", "type": "x/msg/Y"}, "invalid", "/grip carries", None),
        ("topic.publish", {"topic": "grip", "qos": {"depth": 0}}, "invalid", "qos: ", None),
        (
            "topic.publish",
            {"topic": "grip", "qos": {"durability": "long"}},
            "invalid",
            "qos.durability is one of transient_local, volatile",
            None,
        ),
        ("service.type", {"service": "swich"}, "unknown", "no service 'swich'", ["/switch"]),
        ("service.type", {"service": "double"}, "failed", "has no schema", None),
        ("service.call", {"service": "double"}, "failed", "has no schema", None),
        ("service.call", {"service": "nothing"}, "unknown", "there is no service", None),
        ("service.call", {"service": "switch"}, "invalid", "begin as CDR", None),
        (
            "service.call",
            {"service": "switch", "type": "std_srvs/srv/Trigger"},
            "invalid",
            "/switch is of type std_srvs/srv/SetBool, not std_srvs/srv/Trigger",
            None,
        ),
    ],
)
def test_a_wrong_request_is_told_what_is_wrong(
    app: BaseManager,
    ask_for: str,
    arguments: dict[str, Any],
    kind: str,
    text: str,
    suggestions: list[str] | None,
) -> None:
    def questions(client: Asker) -> None:
        answer = client.answer(ask_for, **arguments)
        assert (answer.get("kind"), text in answer.get("error", "")) == (kind, True), answer
        if suggestions:
            assert answer["suggestions"] == suggestions

    ask(app, questions)


# Echo.


def test_messages_are_echoed_in_order_with_their_dates(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        publisher: Any = robot(app).imu
        with streaming(client, "topic.echo", topic="/imu/data") as (number, told):
            begin_ns = app.backend.clock.now_ns()
            for count in range(50):
                publisher.publish(Imu(angular_velocity=Vector3(float(count))))
            read = decoder(told["type"], told["schema"])
            last_ns = begin_ns
            for count in range(50):
                facts, data = event(client, number)
                assert read(data)["angular_velocity"]["x"] == float(count)
                assert last_ns <= facts["stamp_ns"] <= app.backend.clock.now_ns()
                assert facts["dropped"] == 0
                last_ns = facts["stamp_ns"]
            end(client, number)

    ask(app, questions)


def test_a_topic_is_as_before_once_the_client_has_left(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        publisher: Any = robot(app).imu
        before = publisher._deliveries
        with Asker(own_socket()) as other:
            for what in ("topic.echo", "topic.count", "topic.echo"):
                other.ask(what, topic="/imu/data")
            assert len(publisher._deliveries) == len(before) + 3
        wait_until(lambda: publisher._deliveries is before, "the end of the taps")
        assert not app.backend._bus._taps  # type: ignore[attr-defined]  # a local one
        assert client.ask("topic.list")

    ask(app, questions)


def test_a_slow_client_loses_the_oldest_and_is_told(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        publisher: Any = robot(app).grip
        with streaming(client, "topic.echo", topic="/grip", limit=5) as (number, _):
            # Nobody reads: what the socket holds comes, then the last ones.
            for count in range(60_000):
                publisher.publish(Grip(float(count)))
            publisher.publish(Grip(-1.0))
            seen: list[float] = []
            while not seen or seen[-1] != -1.0:
                facts, data = event(client, number)
                seen.append(deserialize(data, Grip).width)
            assert facts["dropped"] == 60_001 - len(seen) > 0
            assert seen == [*sorted(seen[:-1]), -1.0]
            end(client, number)
            wait_until(lambda: client.ask("process")["dropped"] == facts["dropped"], "the count")

    ask(app, questions)


def test_what_a_latched_publisher_keeps_is_echoed_first(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        publisher: Any = robot(app).grip
        for count in range(5):
            publisher.publish(Grip(float(count)))
        with streaming(client, "topic.echo", topic="/grip") as (number, _):
            publisher.publish(Grip(5.0))
            found = [event(client, number) for _ in range(3)]
            assert [deserialize(data, Grip).width for _, data in found] == [3.0, 4.0, 5.0]
            # Nobody knows when they were published.
            dates = [facts["stamp_ns"] for facts, _ in found]
            assert [date is None for date in dates] == [True, True, False]
            end(client, number)

    ask(app, questions)


def test_only_some_messages_are_echoed_if_that_is_asked(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        publisher: Any = robot(app).grip
        hour_ns = 3600 * 10**9
        with streaming(client, "topic.echo", topic="/grip", every_ns=hour_ns) as (number, _):
            for count in range(10):
                publisher.publish(Grip(float(count)))
            facts, data = event(client, number)
            assert (deserialize(data, Grip).width, facts["dropped"]) == (0.0, 0)
            end(client, number)

    ask(app, questions)


def test_a_message_that_has_no_bytes_is_left_out(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        publisher: Any = robot(app).grip
        with streaming(client, "topic.echo", topic="/grip") as (number, _):
            publisher.publish(Grip("wide"))  # type: ignore[arg-type]  # the mistake
            publisher.publish(Grip(2.0))
            _, data = event(client, number)
            assert deserialize(data, Grip) == Grip(2.0)
            end(client, number)

    ask(app, questions)


def test_the_transitions_of_a_node_are_echoed(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        topic = "/camera/transition_event"
        with streaming(client, "topic.echo", topic=topic) as (number, told):
            with Asker(own_socket()) as other:
                other.ask("lifecycle.set", node="camera", transition="deactivate")
            read = decoder(told["type"], told["schema"])
            goals = {read(event(client, number)[1])["goal_state"]["label"] for _ in range(2)}
            assert goals == {"deactivating", "inactive"}
            end(client, number)

    ask(app, questions)


class FakeTopic:
    """A backend with one topic, whose messages the test says."""

    name = "/imu"

    def __init__(self, kind: type = Imu) -> None:
        self.backend = LocalBackend(BackendOptions("fake"), Bus())
        self.publisher: Any = self.backend.create_publisher(kind, self.name, 10)


def test_while_messages_come_the_thread_of_the_socket_is_woken_by_none_of_them() -> None:
    now_ns, topic, wakes = [0], FakeTopic(), list[int]()
    stream = TopicEcho(topic.backend.message_format(Imu), 100, 0, lambda: now_ns[0])
    stream._wake = lambda _: wakes.append(now_ns[0])
    stream.open(topic)  # type: ignore[arg-type]  # a stand-in
    topic.publisher.publish(Imu())
    assert len(wakes) == 1
    stream._is_woken = False
    assert stream.take() is not None
    assert stream.take() is None
    for _ in range(10):
        topic.publisher.publish(Imu())
    assert len(wakes) == 1
    now_ns[0] = stream.due_ns or 0
    assert [stream.take() is None for _ in range(11)] == [False] * 10 + [True]
    # Unless there are so many that some would soon be lost.
    for count in range(50):
        assert len(wakes) == 1, count
        topic.publisher.publish(Imu())
    assert len(wakes) == 2
    wakes.pop()
    stream._is_woken = False
    while stream.take():
        pass
    # Then nothing comes until the next look.
    now_ns[0] = stream.due_ns or 0
    assert stream.take() is None
    assert stream.due_ns is None
    topic.publisher.publish(Imu())
    assert len(wakes) == 2
    stream.close()
    topic.backend.close()


def test_a_stream_of_some_messages_looks_for_none_between_them() -> None:
    now_ns, topic, wakes = [0], FakeTopic(), list[int]()
    stream = TopicEcho(topic.backend.message_format(Imu), 1, 50_000_000, lambda: now_ns[0])
    stream._wake = lambda _: wakes.append(now_ns[0])
    stream.open(topic)  # type: ignore[arg-type]  # a stand-in
    for time_ns in (0, 100_000_000, 110_000_000, 200_000_000):
        now_ns[0] = time_ns
        topic.publisher.publish(Imu())
        stream._is_woken = False
        while stream.take():
            pass
        assert stream.due_ns is None
    assert wakes == [0, 100_000_000, 200_000_000]
    stream.close()
    topic.backend.close()


def heard_by(count: int, message: Any) -> tuple[list[TopicEcho], FakeTopic]:
    """Some streams that nobody reads, after a hundred messages."""
    topic, streams = FakeTopic(type(message)), []
    for _ in range(count):
        streams.append(TopicEcho(topic.backend.message_format(type(message)), 100, 0, lambda: 0))
        streams[-1].open(topic)  # type: ignore[arg-type]  # a stand-in
    for _ in range(100):
        topic.publisher.publish(message)
    return streams, topic


@pytest.mark.parametrize(
    "message",
    [
        Image(data=bytes(1_000_000)),
        Image(data=memoryview(bytes(1_000_000))),
        DiagnosticArray(status=(DiagnosticStatus(message="x" * 10_000),) * 100),
    ],
    ids=["bytes", "view", "nested"],
)
@pytest.mark.parametrize("count", [1, 4])
def test_big_messages_that_nobody_reads_are_bounded_in_bytes_of_all_streams(
    message: Any, count: int
) -> None:
    streams, topic = heard_by(count, message)
    kept: list[int] = []
    for stream in streams:
        taken = [len(data) for _, data in iter(stream.take, None)]
        assert stream.dropped == 100 - len(taken)
        kept += taken
        stream.close()
    assert MOST_BYTES // 2 < sum(kept) <= MOST_BYTES
    topic.backend.close()


def test_a_message_larger_than_all_room_is_echoed_if_it_is_the_newest() -> None:
    (stream,), topic = heard_by(1, Image(data=bytes(MOST_BYTES + 1)))
    taken = stream.take()
    assert taken is not None
    assert len(taken[1]) > MOST_BYTES
    assert stream.take() is None
    assert stream.dropped == 99
    stream.close()
    topic.backend.close()


def test_small_messages_are_bounded_by_their_number() -> None:
    streams, topic = heard_by(2, Imu())
    for stream in streams:
        assert sum(1 for _ in iter(stream.take, None)) == 100
        stream.close()
    topic.backend.close()


# Counting.


def test_a_count_is_that_of_the_publisher(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        publisher: Any = robot(app).imu
        every_ns = 50_000_000
        counted = {"topic": "/imu/data", "every_ns": every_ns}
        with streaming(client, "topic.count", **counted) as (number, _):
            published, total, windows = 0, 0, list[dict[str, Any]]()
            while len(windows) < 5:
                for _ in range(7):
                    publisher.publish(Imu())
                    published += 1
                facts, _ = event(client, number)
                total += facts["window"]["count"]
                windows.append(facts["window"])
                assert facts["n"] == total <= published
            while total < published:
                total += event(client, number)[0]["window"]["count"]
            assert total == published
            for window in windows:
                assert window["seconds"] >= 0.01
                if window["count"] > 1:
                    assert 0 < window["min_ns"] <= window["mean_ns"] <= window["max_ns"]
            end(client, number)

    ask(app, questions)


def counting(wanted: set[str], kind: Any = Imu) -> tuple[TopicCount, FakeTopic, list[int]]:
    """A count in virtual time."""
    now_ns, topic = [0], FakeTopic()
    form = topic.backend.message_format(kind)
    stream = TopicCount("sensor_msgs/msg/Imu", form, wanted, 10**9, lambda: now_ns[0])
    stream.open(topic)  # type: ignore[arg-type]  # a stand-in
    return stream, topic, now_ns


def test_the_figures_of_a_window_are_right() -> None:
    stream, topic, now_ns = counting({"interval"})
    facts: Any
    for time_ns in (0, 100_000_000, 300_000_000, 600_000_000):
        now_ns[0] = time_ns
        topic.publisher.publish(Imu())
    # In parts, so that none takes long.
    assert stream.due_ns == 250_000_000
    assert stream.take() is None
    assert stream.due_ns == 850_000_000
    now_ns[0] = 10**9
    facts, _ = stream.take() or ({}, b"")
    assert facts == {
        "n": 4,
        "window": {
            "count": 4,
            "seconds": 1.0,
            "min_ns": 100_000_000,
            "max_ns": 300_000_000,
            "mean_ns": 200_000_000.0,
            "std_ns": pytest.approx(81_649_658.09),
        },
    }
    # A window without a message; then the interval goes on from the last one.
    now_ns[0] = 3_500_000_000
    facts, _ = stream.take() or ({}, b"")
    assert facts["window"]["count"] == 0
    assert facts["window"]["min_ns"] is None
    assert stream._event_ns == 4_000_000_000
    now_ns[0] = 3_600_000_000
    topic.publisher.publish(Imu())
    now_ns[0] = 4_000_000_000
    facts, _ = stream.take() or ({}, b"")
    assert facts["window"]["min_ns"] == 3_000_000_000
    stream.close()
    topic.backend.close()


def test_sizes_and_ages_are_those_of_the_messages() -> None:
    stream, topic, now_ns = counting({"bytes", "delay"})
    date_ns = topic.backend.clock.now_ns()
    sizes = []
    for frame in ("", "imu_link"):
        sent = Imu(Header(Time.from_nanoseconds(date_ns - 2_000_000_000), frame))
        sizes.append(len(serialize(sent)))
        topic.publisher.publish(sent)
    # Messages are looked at soon, so that they need not be kept.
    assert stream.due_ns == 50_000_000
    now_ns[0] = 50_000_000
    assert stream.take() is None
    now_ns[0] = 10**9
    window = (stream.take() or ({}, b""))[0]["window"]
    assert (window["bytes"], window["bytes_count"]) == (sum(sizes), 2)
    assert (window["bytes_min"], window["bytes_max"]) == (min(sizes), max(sizes))
    assert 1_000_000_000 < window["delay_mean_ns"] < 20_000_000_000
    stream.close()
    topic.backend.close()


def test_a_client_that_does_not_read_costs_a_count_no_memory_and_no_message() -> None:
    stream, topic, now_ns = counting({"interval", "bytes"})
    for _ in range(150_000):
        topic.publisher.publish(Imu())
    assert len(stream._times) == 100_000
    assert len(stream._messages) == 1_000
    now_ns[0] = 10**9
    facts, _ = stream.take() or ({}, b"")
    assert facts["n"] == facts["window"]["count"] == 150_000
    stream.close()
    topic.backend.close()


def counting_all(*names: str) -> tuple[TopicCounts, FakeTopic, list[int]]:
    """A count of several topics in virtual time."""
    now_ns, topic = [0], FakeTopic()
    topics: Any = [SimpleNamespace(name=n, type_name="x/Y", backend=topic.backend) for n in names]
    return TopicCounts(topics, 10**9, lambda: now_ns[0]), topic, now_ns


def facts_of(stream: TopicCounts) -> Any:
    """The next event, from its text."""
    text, data = stream.take() or ("", b"no event")
    assert data == b""
    return json.loads(text)


def test_one_stream_counts_many_topics_and_tells_of_those_with_messages() -> None:
    stream, topic, now_ns = counting_all("/imu", "/silent")
    assert stream.ok == {"topics": {"/imu": "x/Y", "/silent": "x/Y"}}
    for time_ns in (0, 100_000_000, 600_000_000):
        now_ns[0] = time_ns
        topic.publisher.publish(Imu())
    assert stream.take() is None
    now_ns[0] = 10**9
    counts = {"/imu": {"count": 3, "age_ns": 400_000_000}}
    assert facts_of(stream) == {"seconds": 1.0, "topics": counts}
    assert stream.take() is None
    # Late, and without a message; the events keep their rhythm.
    now_ns[0] = 3_500_000_000
    assert facts_of(stream) == {"seconds": 2.5, "topics": {}}
    assert stream.due_ns == 4_000_000_000
    stream.close()
    topic.publisher.publish(Imu())
    assert stream._topics[0].take(now_ns[0]) == ""
    topic.backend.close()


def test_a_client_that_does_not_read_costs_the_count_of_many_topics_no_memory() -> None:
    stream, topic, now_ns = counting_all("/imu")
    for _ in range(10_000):
        topic.publisher.publish(Imu())
    assert len(stream._topics[0]._newest) == 2
    now_ns[0] = 10**9
    assert facts_of(stream)["topics"]["/imu"]["count"] == 10_000
    stream.close()
    topic.backend.close()


def test_many_topics_are_counted_on_one_connection(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        publisher: Any = robot(app).imu
        wanted = {"topics": ["/imu/data", "/nobody"], "every_ns": 20_000_000}
        with streaming(client, "topic.count", **wanted) as (number, ok):
            assert ok == {"topics": {"/imu/data": "sensor_msgs/msg/Imu"}}
            for _ in range(7):
                publisher.publish(Imu())
            total = 0
            while total < 7:
                facts, _ = event(client, number)
                total += facts["topics"].get("/imu/data", {"count": 0})["count"]
            assert total == 7
            end(client, number)

    ask(app, questions)


# Publishing.


def test_a_client_publishes_as_long_as_it_is_connected(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        told = client.ask("topic.type", topic="/words")
        write = encoder(told["type"], told["schema"])
        with Asker(own_socket()) as other:
            # Without a message, to wait for subscriptions.
            assert other.ask("topic.publish", topic="/words") == {"subscriptions": 1}
            for word in ("a", "b"):
                other.ask("topic.publish", write({"data": word}), topic="/words")
            topics = {topic["name"]: topic for topic in other.ask("topic.list")["topics"]}
            assert len(topics["/words"]["publishers"]) == 1
            answer = other.answer("topic.publish", b"\0\1\0\0\xff\0\0\0", topic="/words")
            assert answer["kind"] == "invalid"
        wait_until(lambda: len(robot(app).heard) == 2, "the messages")

        def publishers() -> list[Any]:
            topics = {topic["name"]: topic for topic in client.ask("topic.list")["topics"]}
            return list(topics["/words"]["publishers"])

        wait_until(lambda: not publishers(), "the end of the publisher")

    ask(app, questions)
    assert robot(app).heard == [String("a"), String("b")]


def test_a_client_may_publish_on_a_new_topic_with_a_profile(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        latched = {"durability": "transient_local", "depth": 1}
        arguments = {"topic": "/new", "type": "my_msgs/msg/Grip", "qos": latched}
        data = serialize(Grip(3.0))
        assert client.ask("topic.publish", data, **arguments) == {"subscriptions": 0}
        got: list[Any] = []
        app.backend.create_subscription(Grip, "new", got.append, LATCHED)
        wait_until(lambda: got == [Grip(3.0)], "what was kept")
        named = {**arguments, "program": "app", "topic": "other"}
        assert client.ask("topic.publish", data, **named) == {"subscriptions": 0}

    ask(app, questions)


# Services.


def test_the_services_are_listed_and_told_with_their_types(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        services = {one["name"]: one for one in client.ask("service.list")["services"]}
        assert services["/switch"] == {
            "name": "/switch",
            "type": "std_srvs/srv/SetBool",
            "servers": ["/app"],
            "clients": [],
        }
        assert services["/elsewhere"]["clients"] == ["/app"]
        assert services["/camera/get_state"]["type"] == "lifecycle_msgs/srv/GetState"
        told = client.ask("service.type", service="switch")
        assert told["request"]["schema"] == "bool data\n"
        assert told["response"]["type"] == "std_srvs/srv/SetBool_Response"
        assert client.ask("service.type", type="std_srvs/srv/SetBool") == told
        standard = client.ask("service.type", service="/camera/change_state")
        assert standard["request"]["type"] == "lifecycle_msgs/srv/ChangeState_Request"

    ask(app, questions)


def test_services_are_called(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        number = client.send("service.call", serialize(SetBool.Request(True)), service="switch")
        frame, data = client.read()
        assert frame["id"] == number
        assert frame["ok"]["took_ns"] > 0
        assert deserialize(data, SetBool.Response) == SetBool.Response(True, "on")
        answer = client.answer("service.call", serialize(SetBool.Request()), service="switch")
        assert (answer["kind"], "stuck" in answer["error"] or "raised" in answer["error"]) == (
            "failed",
            True,
        )
        short = {"service": "/none", "type": "std_srvs/srv/Trigger", "timeout_ns": 10_000_000}
        answer = client.answer("service.call", serialize(Trigger.Request()), **short)
        assert answer["kind"] == "timeout"
        assert "no such service" in answer["error"]
        told = client.ask("service.type", service="/camera/get_state")
        write = encoder(told["request"]["type"], told["request"]["schema"])
        client.send("service.call", write({}), service="/camera/get_state")
        frame, data = client.read()
        read = decoder(told["response"]["type"], told["response"]["schema"])
        assert read(data)["current_state"]["label"] == "active"
        # Nothing of it is left.
        assert not [end for end in app.backend.graph().clients if end.name != "/elsewhere"]

    ask(app, questions)


def test_what_is_read_is_answered_while_the_loop_blocks_and_calls_time_out(
    app: BaseManager,
) -> None:
    release = threading.Event()

    def questions(client: Asker) -> None:
        app.backend.call_soon(release.wait)
        try:
            assert client.ask("topic.list")["topics"]
            with streaming(client, "topic.echo", topic="/imu/data") as (number, _):
                publisher: Any = robot(app).imu
                publisher.publish(Imu())
                event(client, number)
                end(client, number)
            request = serialize(SetBool.Request(True))
            answer = client.answer("service.call", request, service="switch", timeout_ns=10_000_000)
            assert answer["kind"] == "timeout"
            assert "the main loop of /app is busy" in answer["error"]
        finally:
            release.set()

    ask(app, questions)


CHILD_PROGRAM = """
from rosbase import (BaseHandlers, BaseManager, BaseNode, qos_profile_sensor_data,
                     register_multiprocess_nodes)
from rosbase.messages import String

class Child(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.words = self.create_publisher(String, "words", 10)
        self.count = 0
        self.create_timer(0.01, self.talk)
    def talk(self):
        self.count += 1
        self.words.publish(String(str(self.count)))

class Node(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_subscription(String, "words", lambda message: None, 10)
        self.create_subscription(String, "words", lambda message: None, qos_profile_sensor_data)

class Handlers(BaseHandlers):
    def handle(self):
        pass

if __name__ == "__main__":
    processes = register_multiprocess_nodes({"child": Child}, {})
    manager = BaseManager("app", {"node": Node}, {}, Handlers, node_freq_hz=50)
    manager.start_main_loop_timer(processes)
"""


def test_what_a_child_publishes_is_heard_in_both_processes(tmp_path: Path) -> None:
    with running(tmp_path, CHILD_PROGRAM) as program, connected(program.process.pid) as manager:

        def child() -> dict[str, Any] | None:
            (told,) = manager.ask("process")["programs"]
            return next((one for one in told["children"] if one["running"]), None)

        wait_until(child, "the child")
        pid = (child() or {})["pid"]
        for path_of in (pid, program.process.pid):
            with connected(path_of) as client:

                def is_there(client: Asker = client) -> bool:
                    return "ok" in client.answer("topic.type", topic="/words")

                wait_until(is_there, "the topic")
                told = client.ask("topic.echo", topic="/words")
                read = decoder(told["type"], told["schema"])
                words = [int(read(client.read()[1])["data"]) for _ in range(20)]
                # Each once, in order.
                assert words == [words[0] + number for number in range(20)]
        manager.ask("stop")
        status, _, err = program.end()
        assert status == 0, err
