"""Taps and the graph on ROS, beside what every backend promises (test_ros2_contract.py)."""

import re
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray as RosDiagnosticArray
from geometry_msgs.msg import Vector3 as RosVector3
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu as RosImu
from std_srvs.srv import Trigger as RosTrigger
from test_msgs.msg import BoundedSequences, Defaults, Empty, WStrings

from rosbase.contracts.backend import BackendOptions
from rosbase.messages import Imu, TFMessage, Vector3
from rosbase.messages.std_srvs import Trigger
from rosbase.qos import DurabilityPolicy, QoSProfile
from rosbase.wire import deserialize, schema, type_hash
from rosbase.wire.plain import decoder, encoder
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.formats import structure_of
from support.ros import Open
from support.waiting import wait_until
from support.wire_messages import CLASSES

# No wheel of ROS has the package tf2_msgs.
OF_ROS = [cls for cls in CLASSES if cls is not TFMessage]


@pytest.fixture
def outside(context: Any) -> Iterator[Any]:
    """A node of rclpy of another context, as another program has it."""
    node: Any = rclpy.create_node("outside", context=context)
    yield node
    node.destroy_node()


def spin(backend: Ros2Backend, until: Any, meanwhile: Any = lambda: None) -> None:
    def holds() -> bool:
        meanwhile()
        deadline_ns = backend.executor.clock.monotonic_ns() + 5_000_000
        backend.spin_until(deadline_ns, until)
        return bool(until())

    wait_until(holds, "it")


def test_a_publisher_is_as_before_once_the_tap_has_gone(backend: Ros2Backend) -> None:
    publisher: Any = backend.create_publisher(Vector3, "point", 10)
    send = backend.prepared_sender(publisher, Vector3(), ["x"])
    before, heard = publisher._send, list[Any]()
    tap = backend.add_tap("point", heard.append)
    send(1.0)
    publisher.publish(Vector3(2.0))
    assert [deserialize(data, Vector3).x for data in heard] == [1.0, 2.0]
    tap.close()
    send(3.0)
    assert len(heard) == 2
    assert publisher._send == before == type(publisher.inner).publish.__get__(publisher.inner)
    assert "publish" not in vars(publisher.inner)


def test_a_latched_publisher_keeps_what_it_was_when_published(backend: Ros2Backend) -> None:
    latched = QoSProfile(2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = backend.create_publisher(RosVector3, "point", latched)
    filled = RosVector3()
    for count in range(3):
        filled.x = float(count)
        publisher.publish(filled)
    kept = backend.kept_messages("point")
    assert [backend.message_format(Vector3).decode(data).x for data in kept] == [1.0, 2.0]
    assert backend.kept_messages("other") == []


def test_a_subscription_is_as_before_once_the_tap_has_gone(backend: Ros2Backend) -> None:
    subscription: Any = backend.create_subscription(Vector3, "point", print, 10)
    before = subscription.inner.callback
    tap = backend.add_tap("point", print)
    assert subscription.inner.callback != before
    backend.create_subscription(Vector3, "point", print, 10)
    tap.close()
    assert subscription.inner.callback == before == subscription.deliver


def test_what_the_program_publishes_with_rclpy_is_heard_too(backend: Ros2Backend) -> None:
    heard: list[Any] = []
    early = backend.node.create_publisher(RosVector3, "point", 10)
    tap = backend.add_tap("point", heard.append)
    later = backend.node.create_publisher(RosVector3, "point", 10)
    log = backend.add_tap("/rosout", heard.append)
    early.publish(RosVector3(x=1.0))
    later.publish(RosVector3(x=2.0))
    assert [message.x for message in heard] == [1.0, 2.0]
    # An end that has gone is no obstacle.
    backend.node.destroy_publisher(early)
    log.close()
    tap.close()


def test_messages_of_ros_classes_are_heard_and_written(backend: Ros2Backend) -> None:
    heard: list[Any] = []
    publisher = backend.create_publisher(RosImu, "imu", 10)
    backend.add_tap("imu", heard.append)
    sent = RosImu()
    sent.linear_acceleration.z = 9.81
    publisher.publish(sent)
    assert heard == [sent]
    own, theirs = backend.message_format(Imu), backend.message_format(RosImu)
    assert own.encode(sent) == theirs.encode(sent) == bytes(serialize_message(sent))
    assert theirs.decode(theirs.encode(sent)) == sent
    assert own.decode(theirs.encode(sent)).linear_acceleration.z == 9.81
    assert (own.schema, own.type_hash) == (theirs.schema, theirs.type_hash)


@pytest.mark.parametrize("cls", OF_ROS, ids=lambda cls: cls.__name__)
def test_a_class_of_ros_has_the_schema_of_the_class_of_rosbase(
    backend: Ros2Backend, cls: Any
) -> None:
    from rosbase_ros2.courier import ros_class

    theirs = ros_class(cls.__ros_type__, cls)
    from rosbase.wire.hashes import hash_of
    from rosbase.wire.schemas import schema_of

    assert hash_of(structure_of(theirs)) == type_hash(cls)
    constant = re.compile(r"\S+ [A-Z]\w*=")
    ours = [line for line in schema(cls).splitlines() if not constant.match(line)]
    assert schema_of(structure_of(theirs)).splitlines() == ours


@pytest.mark.parametrize("cls", [BoundedSequences, Defaults, Empty, WStrings])
def test_any_class_of_ros_can_be_read_by_its_schema(backend: Ros2Backend, cls: Any) -> None:
    form = backend.message_format(cls)
    read, write = decoder(form.type_name, form.schema), encoder(form.type_name, form.schema)
    # Not the very bytes: rclpy leaves any in the gaps.
    assert form.decode(write(read(form.encode(cls())))) == cls()
    if cls is not BoundedSequences:
        # rclpy alone knows the defaults of lists.
        assert form.decode(write({})) == cls()


@pytest.mark.parametrize("own_class", [Vector3, RosVector3])
@pytest.mark.parametrize("heard_class", [Vector3, RosVector3])
def test_of_own_and_foreign_messages_each_is_heard_once(
    backend: Ros2Backend, outside: Any, own_class: Any, heard_class: Any
) -> None:
    """One publisher is in this process, one outside, and both say the same."""
    got: list[float] = []
    heard: list[float] = []
    encode = backend.message_format(Vector3).encode

    def hear(message: Any) -> None:
        data = message if isinstance(message, bytes) else encode(message)
        heard.append(deserialize(data, Vector3).x)

    backend.create_subscription(heard_class, "point", lambda message: got.append(message.x), 100)
    own = backend.create_publisher(own_class, "point", 100)
    foreign = outside.create_publisher(RosVector3, "point", 100)
    spin(backend, lambda: -1.0 in got, lambda: foreign.publish(RosVector3(x=-1.0)))
    spin(backend, lambda: -2.0 in got, lambda: own.publish(own_class(x=-2.0)))
    tap = backend.add_tap("point", hear)
    before = len(got)
    for number in range(50):
        own.publish(own_class(x=float(number)))
        foreign.publish(RosVector3(x=float(number)))
    spin(backend, lambda: sum(one >= 0 for one in got[before:]) == 100)
    wait_until(lambda: sum(one >= 0 for one in heard) >= 100, "what the tap hears")
    assert sorted(one for one in heard if one >= 0) == [n // 2 for n in range(100)]
    tap.close()


def test_the_graph_is_what_rclpy_says(opened: Open, outside: Any) -> None:
    backend = opened("-r", "scan:=/front/scan")
    inner = backend.open_node("arm", is_lifecycle=True)
    backend.create_publisher(Imu, "scan", 10)
    inner.create_subscription(RosDiagnosticArray, "~/diagnostics", print, 10)
    backend.node.create_publisher(RosImu, "native", 10)
    inner.create_service(Trigger, "open", lambda request: Trigger.Response())
    backend.create_client(RosTrigger, "open")

    def asked(kind: str) -> set[tuple[str, str, str]]:
        names = {
            "publishers": outside.get_publisher_names_and_types_by_node,
            "subscriptions": outside.get_subscriber_names_and_types_by_node,
            "services": outside.get_service_names_and_types_by_node,
            "clients": outside.get_client_names_and_types_by_node,
        }[kind]
        known = {name for name, space in outside.get_node_names_and_namespaces()}
        return {
            (f"/{node}", name, types[0])
            for node in ("driver", "arm")
            if node in known
            for name, types in names(node, "/")
        }

    def told(kind: str) -> set[tuple[str, str, str]]:
        ends: Any = getattr(backend.graph(), kind)
        return {(end.node, end.name, end.type_name) for end in ends}

    for kind in ("publishers", "subscriptions", "services", "clients"):
        wait_until(lambda kind=kind: asked(kind) == told(kind), kind)  # type: ignore[misc]  # of this turn
    assert ("/driver", "/front/scan", "sensor_msgs/msg/Imu") in told("publishers")
    assert ("/driver", "/native", "sensor_msgs/msg/Imu") in told("publishers")
    assert ("/arm", "/open", "std_srvs/srv/Trigger") in told("services")
    assert backend.add_tap("scan", print).topic == "/front/scan"
    classes = {end.name: end.msg_type for end in backend.graph().publishers}
    assert (classes["/front/scan"], classes["/native"]) == (Imu, RosImu)


def test_a_failing_tap_is_logged_once_and_removed(
    backend: Ros2Backend, capfd: pytest.CaptureFixture[str]
) -> None:
    publisher: Any = backend.create_publisher(Vector3, "point", 10)

    def fail(message: Any) -> None:
        raise RuntimeError("no more")

    backend.add_tap("point", fail)
    publisher.publish(Vector3())
    publisher.publish(Vector3())
    while backend.spin_once(0.0):
        pass
    assert "publish" not in vars(publisher.inner)
    shown = capfd.readouterr().err
    assert shown.count("/point: a tap has ended, because it raised RuntimeError: no more") == 1


def test_taps_end_with_their_backend() -> None:
    backend = Ros2Backend(BackendOptions("ending"))
    tap = backend.add_tap("point", print)
    backend.close()
    assert tap.is_closed
    assert backend.graph().publishers == ()
