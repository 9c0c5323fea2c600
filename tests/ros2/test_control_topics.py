"""Topics and services of a program on ROS, asked over the control socket and with rclpy."""

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from diagnostic_msgs.msg import KeyValue as RosKeyValue
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import Imu as RosImu
from std_msgs.msg import String as RosString
from std_srvs.srv import SetBool as RosSetBool

from rosbase import BackendOptions, BaseHandlers, BaseManager, BaseNode, LifecycleNode
from rosbase.messages import Imu, String, Vector3
from rosbase.messages.std_srvs import SetBool
from rosbase.wire import deserialize, serialize, type_hash
from rosbase.wire.plain import decoder, encoder
from rosbase_ros2.backend import Ros2Backend
from support.control import Asker, ask_while_running
from support.waiting import wait_until


class Robot(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.imu = self.create_publisher(Imu, "imu/data", 50)
        self.native = self.create_publisher(RosKeyValue, "native", 5)
        self.heard: list[Any] = []
        self.create_subscription(String, "words", self.heard.append, 10)
        self.create_service(SetBool, "switch", lambda request: SetBool.Response(request.data, "x"))


class Arm(LifecycleNode):
    autostart = "activate"


class Handlers(BaseHandlers):
    def handle(self) -> None:
        pass


@pytest.fixture
def app() -> Iterator[BaseManager]:
    backend = Ros2Backend(BackendOptions("app"))
    yield BaseManager("app", {"robot": Robot, "arm": Arm}, {}, Handlers, 100, backend=backend)
    backend.close()


@pytest.fixture
def outside(context: Any) -> Iterator[Any]:
    """A node of rclpy that is spun, as another program has it."""
    node: Any = rclpy.create_node("outside", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    is_over = threading.Event()

    def spin() -> None:
        while not is_over.is_set():
            executor.spin_once(0.05)

    thread = threading.Thread(target=spin)
    thread.start()
    yield node
    is_over.set()
    thread.join()
    executor.remove_node(node)
    executor.shutdown()
    node.destroy_node()


def ask(app: BaseManager, questions: Callable[[Asker], None]) -> None:
    ask_while_running(app, questions)


def test_topics_and_services_are_those_that_rclpy_sees(app: BaseManager, outside: Any) -> None:
    def seen(infos: Callable[[str], Any], name: str) -> list[tuple[str, str, str]]:
        return sorted(
            (
                f"/{info.node_name}",
                info.qos_profile.reliability.name.lower(),
                info.qos_profile.durability.name.lower(),
            )
            for info in infos(name)
            if info.node_name in ("app", "arm")
        )

    def told(ends: Any) -> list[tuple[str, str, str]]:
        return sorted(
            (end["node"], end["qos"]["reliability"], end["qos"]["durability"]) for end in ends
        )

    def questions(client: Asker) -> None:
        def agree() -> bool:
            topics = client.ask("topic.list")["topics"]
            return all(
                told(topic["publishers"])
                == seen(outside.get_publishers_info_by_topic, topic["name"])
                and told(topic["subscriptions"])
                == seen(outside.get_subscriptions_info_by_topic, topic["name"])
                for topic in topics
            )

        wait_until(agree, "the same answers")
        types = dict(outside.get_topic_names_and_types())
        topics = {one["name"]: [one["type"]] for one in client.ask("topic.list")["topics"]}
        assert {"/imu/data", "/native", "/words", "/rosout", "/arm/transition_event"} <= {*topics}
        assert topics == {name: types[name] for name in topics}
        services = {one["name"]: [one["type"]] for one in client.ask("service.list")["services"]}
        known = dict(outside.get_service_names_and_types())
        assert {"/switch", "/arm/change_state", "/app/list_parameters"} <= {*services}
        assert services == {name: known[name] for name in services}

    ask(app, questions)


def test_types_of_rosbase_and_of_ros_are_told(app: BaseManager, outside: Any) -> None:
    def questions(client: Asker) -> None:
        own = client.ask("topic.type", topic="imu/data")
        assert own["hash"] == type_hash(Imu)
        infos = outside.get_publishers_info_by_topic
        wait_until(lambda: infos("/imu/data"), "the publisher")
        (info,) = infos("/imu/data")
        assert own["hash"] == str(info.topic_type_hash)
        native = client.ask("topic.type", topic="native")
        assert native["schema"] == "string key\nstring value\n"
        # One that rosbase has no class for.
        assert client.ask("topic.type", type="test_msgs/msg/Defaults")["schema"]
        assert client.answer("topic.type", type="test_msgs/msg/Nothing")["kind"] == "unknown"

    ask(app, questions)


def test_an_echo_is_what_a_subscriber_of_rclpy_gets(app: BaseManager, outside: Any) -> None:
    got: list[Any] = []
    outside.create_subscription(RosImu, "imu/data", got.append, 50, raw=True)

    def questions(client: Asker) -> None:
        publisher = app.node(Robot).imu
        inner: Any = publisher
        wait_until(lambda: inner.subscription_count == 1, "the subscriber")
        number = client.send("topic.echo", topic="/imu/data")
        told = client.read()[0]["ok"]
        for count in range(20):
            publisher.publish(Imu(angular_velocity=Vector3(float(count))))
        data = [client.read()[1] for _ in range(20)]
        wait_until(lambda: len(got) == 20, "what rclpy gets")
        assert data == got
        assert decoder(told["type"], told["schema"])(data[7])["angular_velocity"]["x"] == 7.0
        client.send("cancel", of=number)

    ask(app, questions)


def test_messages_of_ros_classes_are_echoed_as_they_were_when_published(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        client.send("topic.echo", topic="/native")
        told = client.read()[0]["ok"]
        filled = RosKeyValue()
        for count in range(3):
            # One object, filled again and again.
            filled.value = str(count)
            app.node(Robot).native.publish(filled)
        read = decoder(told["type"], told["schema"])
        assert [read(client.read()[1])["value"] for _ in range(3)] == ["0", "1", "2"]

    ask(app, questions)


def test_what_another_program_publishes_is_heard_and_counted(
    app: BaseManager, outside: Any
) -> None:
    publisher = outside.create_publisher(RosString, "words", 10)

    def questions(client: Asker) -> None:
        wait_until(lambda: publisher.get_subscription_count() == 1, "the subscription")
        client.send("topic.echo", topic="/words")
        told = client.read()[0]["ok"]
        publisher.publish(RosString(data="a"))
        read = decoder(told["type"], told["schema"])
        assert read(client.read()[1]) == {"data": "a"}
        wait_until(lambda: app.node(Robot).heard == [String("a")], "the message")

    ask(app, questions)


def test_a_count_is_that_of_the_publisher(app: BaseManager) -> None:
    def questions(client: Asker) -> None:
        wanted: Any = {"topic": "/imu/data", "every_ns": 50_000_000, "with": ["bytes"]}
        client.send("topic.count", **wanted)
        client.read()
        for _ in range(100):
            app.node(Robot).imu.publish(Imu())
        total = size = 0
        while total < 100:
            window = client.read()[0]["event"]["window"]
            total += window["count"]
            size += window["bytes"]
        assert (total, size) == (100, 100 * len(serialize(Imu())))

    ask(app, questions)


def test_a_client_publishes_to_other_programs(app: BaseManager, outside: Any) -> None:
    got: list[Any] = []
    outside.create_subscription(RosString, "said", got.append, 10)

    def questions(client: Asker) -> None:
        new: Any = {"topic": "said", "type": "std_msgs/msg/String"}
        wait_until(
            lambda: client.ask("topic.publish", **new)["subscriptions"] == 1, "the subscriber"
        )
        told = client.ask("topic.type", topic="said")
        write = encoder(told["type"], told["schema"])
        client.ask("topic.publish", write({"data": "hi"}), **new)
        wait_until(lambda: [message.data for message in got] == ["hi"], "the message")

    ask(app, questions)


def test_services_here_and_of_other_programs_are_called(app: BaseManager, outside: Any) -> None:
    def switch(request: Any, response: Any) -> Any:
        response.success, response.message = request.data, "outside"
        return response

    outside.create_service(RosSetBool, "outside/switch", switch)

    def questions(client: Asker) -> None:
        for arguments, text in (
            ({"service": "switch"}, "x"),
            ({"service": "/outside/switch", "type": "std_srvs/srv/SetBool"}, "outside"),
        ):
            client.send("service.call", serialize(SetBool.Request(True)), **arguments)
            frame, data = client.read()
            assert "ok" in frame, frame
            assert deserialize(data, SetBool.Response) == SetBool.Response(True, text)

    ask(app, questions)
