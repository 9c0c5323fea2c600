"""Taps and the graph of the local backend, beside what every backend promises (the kit)."""

import socket
import threading
from collections.abc import Iterator
from multiprocessing.connection import Connection
from typing import Any

import pytest

from rosbase.contracts.backend import BackendOptions
from rosbase.contracts.graph import type_name_of
from rosbase.errors import BackendError
from rosbase.local import Bus, LocalBackend
from rosbase.local.link import Link
from rosbase.messages import Imu, Vector3
from rosbase.messages.rcl_interfaces import GetParameters
from rosbase.messages.std_srvs import Trigger
from rosbase.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase.testing import virtual_backend
from support.waiting import wait_until

LATCHED = QoSProfile(3, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(5, reliability=ReliabilityPolicy.BEST_EFFORT)


class Filled:
    """A message as programs for rclpy have it: one object, filled again and again."""

    def __init__(self) -> None:
        self.x = 0


@pytest.mark.parametrize("kind", [Vector3, Filled])
@pytest.mark.parametrize("profile", [QoSProfile(), LATCHED])
def test_publishers_of_every_kind_are_tapped_and_then_as_before(
    kind: Any, profile: QoSProfile
) -> None:
    backend = virtual_backend()
    publisher: Any = backend.create_publisher(kind, "point", profile)
    backend.create_subscription(kind, "point", print, 10)
    before, heard = publisher._deliveries, list[Any]()
    taps = [backend.add_tap("point", heard.append) for _ in range(2)]
    sent = kind()
    publisher.publish(sent)
    assert len(publisher._deliveries) == 3
    # A copy of what can be changed, and the same for all.
    assert heard[0] is heard[1]
    assert (heard[0] is sent) is (kind is Vector3)
    for tap in taps:
        tap.close()
    publisher.publish(sent)
    assert len(heard) == 2
    assert publisher._deliveries is before
    backend.close()


def test_a_tap_hands_to_another_function_until_it_is_closed() -> None:
    backend = virtual_backend()
    publisher = backend.create_publisher(Vector3, "point", 10)
    before, after = list[Any](), list[Any]()
    tap = backend.add_tap("point", before.append)
    publisher.publish(Vector3(1.0))
    tap.hand_to(after.append)
    publisher.publish(Vector3(2.0))
    tap.close()
    tap.hand_to(before.append)
    tap.take(Vector3(3.0))
    assert before == [Vector3(1.0)]
    assert after == [Vector3(2.0)]
    backend.close()


def test_a_tap_hears_nothing_that_was_kept() -> None:
    backend = virtual_backend()
    publisher = backend.create_publisher(Vector3, "point", LATCHED)
    publisher.publish(Vector3(1.0))
    heard: list[Any] = []
    backend.add_tap("point", heard.append)
    publisher.publish(Vector3(2.0))
    assert heard == [Vector3(2.0)]
    backend.close()


def test_subscriptions_may_come_and_go_while_there_is_a_tap() -> None:
    backend = virtual_backend()
    heard: list[Any] = []
    tap = backend.add_tap("point", heard.append)
    publisher: Any = backend.create_publisher(Vector3, "point", 10)
    assert len(publisher._deliveries) == 1
    subscription: Any = backend.create_subscription(Vector3, "point", print, 10)
    publisher.publish(Vector3())
    assert len(heard) == 1
    tap.close()
    assert publisher._deliveries == (subscription.deliver,)
    backend.destroy_subscription(subscription)
    assert publisher._deliveries == ()
    backend.close()


def test_a_failing_tap_of_a_latched_topic_is_logged_once_and_removed(
    caplog: pytest.LogCaptureFixture,
) -> None:
    backend = virtual_backend()
    publisher: Any = backend.create_publisher(Vector3, "point", LATCHED)

    def fail(message: Vector3) -> None:
        raise RuntimeError("no more")

    backend.add_tap("point", fail)
    publisher.publish(Vector3())
    publisher.publish(Vector3())
    while backend.spin_once(0.0):
        pass
    line = "/point: a tap has ended, because it raised RuntimeError: no more"
    assert [record.getMessage() for record in caplog.records] == [line]
    assert publisher._deliveries == ()
    backend.close()


def test_taps_end_with_their_backend() -> None:
    bus = Bus()
    ending, other = (LocalBackend(BackendOptions(name), bus) for name in ("ending", "other"))
    publisher: Any = other.create_publisher(Vector3, "point", 10)
    heard: list[Any] = []
    tap = ending.add_tap("point", heard.append)
    publisher.publish(Vector3())
    ending.close()
    publisher.publish(Vector3())
    assert (len(heard), tap.is_closed, publisher._deliveries) == (1, True, ())
    assert not bus._taps
    other.close()


def test_a_node_of_a_manager_taps_by_its_own_names() -> None:
    backend = virtual_backend(node_name="robot")
    node = backend.open_node("camera", is_lifecycle=True)
    assert node.add_tap("~/image", print).topic == "/camera/image"
    assert backend.open_node("plain", is_lifecycle=False).add_tap("~/image", print).topic == (
        "/robot/image"
    )
    backend.close()
    with pytest.raises(BackendError, match="closed"):
        node.add_tap("image", print)


class Linked:
    """Two buses of one process, with a link between them, as between a manager and its child."""

    def __init__(self) -> None:
        self.buses = Bus(), Bus()
        self.here, self.there = (
            LocalBackend(BackendOptions(name), bus)
            for name, bus in zip(("here", "there"), self.buses, strict=True)
        )
        ends = socket.socketpair()
        self.links = [
            Link(bus, Connection(end.detach()), "other")
            for bus, end in zip(self.buses, ends, strict=True)
        ]
        for link in self.links:
            link.start()

    def hears(self, topic: str, count: int) -> bool:
        """Whether that many channels of a topic are known at the other side."""
        found = self.buses[1]._topics.get(topic)
        return found is not None and len(found.subscriptions) == count

    def close(self) -> None:
        for link in self.links:
            link.close()
        self.here.close()
        self.there.close()


@pytest.fixture
def linked() -> Iterator[Linked]:
    pair = Linked()
    yield pair
    pair.close()


@pytest.mark.parametrize(
    "profiles",
    [
        [QoSProfile()],
        [BEST_EFFORT],
        [QoSProfile(), BEST_EFFORT, QoSProfile(20), LATCHED, LATCHED],
        [LATCHED, LATCHED],
    ],
)
def test_what_a_child_publishes_is_heard_once_whoever_subscribes(
    linked: Linked, profiles: list[QoSProfile]
) -> None:
    heard: list[float] = []
    got: list[float] = []
    tap = linked.here.add_tap("point", lambda message: heard.append(message.x))
    for profile in profiles:
        linked.here.create_subscription(Vector3, "point", lambda m: got.append(m.x), profile)
    channels = len({p.reliability for p in profiles if not p.is_latched}) + len(
        [p for p in profiles if p.is_latched]
    )
    wait_until(lambda: linked.hears("/point", channels), "the audience")
    publisher = linked.there.create_publisher(Vector3, "point", LATCHED)
    for number in range(3):
        publisher.publish(Vector3(float(number)))
    deadline_ns = linked.here.clock.monotonic_ns() + 20 * 10**9
    linked.here.spin_until(deadline_ns, lambda: len(got) >= 3 * len(profiles))
    assert heard == [0.0, 1.0, 2.0]
    tap.close()
    assert "deliver_from" not in vars(linked.buses[0])


def test_what_nobody_wants_here_is_not_fetched_for_a_tap(linked: Linked) -> None:
    heard: list[Any] = []
    linked.here.add_tap("point", heard.append)
    linked.here.create_subscription(Vector3, "other", print, 10)
    wait_until(lambda: linked.hears("/other", 1), "the audience")
    publisher: Any = linked.there.create_publisher(Vector3, "point", 10)
    assert publisher._deliveries == ()


def test_a_tap_hears_what_it_can_while_others_publish_and_taps_come_and_go() -> None:
    backend = virtual_backend()
    publisher: Any = backend.create_publisher(Vector3, "point", LATCHED)
    is_over = threading.Event()
    sent = [0]

    def publish() -> None:
        while not is_over.is_set():
            publisher.publish(Vector3(float(sent[0])))
            sent[0] += 1

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        for _ in range(200):
            heard: list[Any] = []
            tap = backend.add_tap("point", heard.append)
            wait_until(lambda found=heard: len(found) > 3, "messages")  # type: ignore[misc]  # of this turn
            tap.close()
            numbers = [message.x for message in heard]
            assert numbers == [numbers[0] + number for number in range(len(numbers))]
    finally:
        is_over.set()
        thread.join()
    assert publisher._deliveries == ()
    backend.close()


def test_the_transitions_of_a_node_can_be_tapped_without_a_subscription() -> None:
    backend = virtual_backend()
    node = LifecycleNode(None, name="camera", backend=backend)
    heard: list[Any] = []
    topics = {end.name: end.type_name for end in backend.graph().publishers}
    assert topics["/test/transition_event"] == "lifecycle_msgs/msg/TransitionEvent"
    tap = backend.add_tap("/test/transition_event", heard.append)
    node.trigger_configure()
    assert {event.goal_state.label for event in heard} >= {"inactive"}
    assert [end.name for end in backend.graph().publishers].count("/test/transition_event") == 1
    tap.close()
    backend.close()


def test_the_graph_has_the_services_of_parameters_and_of_lifecycles() -> None:
    backend = virtual_backend(node_name="robot")
    backend.open_node("camera", is_lifecycle=True)
    service = backend.create_service(Trigger, "open", lambda request: Trigger.Response())
    found = {(end.node, end.name): end.type_name for end in backend.graph().services}
    assert found["/robot", "/open"] == "std_srvs/srv/Trigger"
    assert found["/camera", "/camera/get_parameters"] == "rcl_interfaces/srv/GetParameters"
    assert found["/robot", "/robot/list_parameters"] == "rcl_interfaces/srv/ListParameters"
    assert backend.graph().nodes == ("/robot", "/camera")
    backend.destroy_service(service)
    assert ("/robot", "/open") not in {(end.node, end.name) for end in backend.graph().services}
    backend.close()
    assert type_name_of(GetParameters) == "rcl_interfaces/srv/GetParameters"


def test_the_graph_counts_what_a_subscription_has_dropped() -> None:
    backend = virtual_backend()
    backend.create_subscription(Imu, "imu", print, 1)
    publisher = backend.create_publisher(Imu, "imu", 1)
    for _ in range(4):
        publisher.publish(Imu())
    (end,) = backend.graph().subscriptions
    assert (end.dropped, end.msg_type, end.profile) == (3, Imu, QoSProfile(1))
    backend.close()


def test_a_class_of_python_has_its_name_as_type() -> None:
    backend = virtual_backend()
    backend.create_publisher(Filled, "own", 1)
    (end,) = [end for end in backend.graph().publishers if end.name == "/own"]
    assert end.type_name.endswith("test_taps.Filled")
    with pytest.raises(TypeError):
        backend.message_format(Filled)
    backend.close()
