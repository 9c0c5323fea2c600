"""Quality of service: what a profile is, and what the local backend makes of it."""

import pickle
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from attrs import define, field
from attrs.exceptions import FrozenInstanceError
from hypothesis import given

import rosbase
from rosbase import (
    BaseNode,
    DurabilityPolicy,
    HistoryPolicy,
    LifecycleNode,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rosbase.contracts.backend import Publisher
from rosbase.local import LocalBackend
from rosbase.messages import Vector3
from rosbase.qos import mismatch
from rosbase.testing import virtual_backend
from support.strategies import QosStep, qos_profiles, qos_steps
from support.waiting import wait_until

BEST_EFFORT = QoSProfile(reliability=ReliabilityPolicy.BEST_EFFORT)
KEEP_ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)


def latched(depth: int = 10, **policies: Any) -> QoSProfile:
    return QoSProfile(depth, durability=DurabilityPolicy.TRANSIENT_LOCAL, **policies)


@pytest.fixture
def backend() -> Iterator[LocalBackend]:
    backend = virtual_backend()
    yield backend
    backend.close()


def subscribe(backend: LocalBackend, profile: int | QoSProfile) -> list[int]:
    """A new subscription: the list into which its messages go, as numbers."""
    got: list[int] = []
    backend.create_subscription(Vector3, "map", lambda m: got.append(int(m.x)), profile)
    return got


def publish(publisher: Publisher[Any], *numbers: int) -> None:
    for number in numbers:
        publisher.publish(Vector3(x=float(number)))


def drain(backend: LocalBackend) -> None:
    while backend.spin_once(0.0):
        pass


def test_a_profile_is_by_default_what_it_is_in_ros() -> None:
    profile = QoSProfile()
    assert profile.depth == 10
    assert profile.reliability is ReliabilityPolicy.RELIABLE
    assert profile.durability is DurabilityPolicy.VOLATILE
    assert profile.history is HistoryPolicy.KEEP_LAST
    assert QoSProfile(3).depth == 3
    assert (qos_profile_sensor_data.depth, qos_profile_sensor_data.reliability) == (
        5,
        ReliabilityPolicy.BEST_EFFORT,
    )


def test_a_profile_does_not_change_and_goes_to_another_process() -> None:
    profile = latched(1)
    with pytest.raises(FrozenInstanceError):
        profile.depth = 2  # type: ignore[misc]  # the mistake is the test
    assert pickle.loads(pickle.dumps(profile)) == profile


@pytest.mark.parametrize("depth", [0, -1, True, 1.5, None, "many"])
def test_a_profile_refuses_what_is_not_a_depth_in_one_line(depth: Any) -> None:
    with pytest.raises(ValueError, match=r"^a depth is a whole number from 1 up, not [^\n]+$"):
        QoSProfile(depth)


def test_a_history_that_keeps_all_ignores_the_depth() -> None:
    assert QoSProfile(0, history=HistoryPolicy.KEEP_ALL).queue_depth == sys.maxsize


def test_a_profile_refuses_what_is_not_a_policy_in_one_line() -> None:
    with pytest.raises(ValueError, match=r"^'latched' is not a valid DurabilityPolicy$"):
        QoSProfile(durability="latched")


def test_rosbase_has_the_names_that_users_of_ros_know() -> None:
    names = {name for name in rosbase.__all__ if name.lower().startswith("qos") or "Policy" in name}
    assert names - {"RestartPolicy"} == {
        *("DurabilityPolicy", "HistoryPolicy", "QoSProfile", "ReliabilityPolicy"),
        "qos_profile_sensor_data",
    }


def test_nodes_take_the_profile_by_the_keyword_of_rclpy(backend: LocalBackend) -> None:
    got: list[Vector3] = []
    node = BaseNode(backend=backend)
    node.create_publisher(Vector3, "map", qos_profile=latched()).publish(Vector3())
    LifecycleNode(backend=backend).create_publisher(Vector3, "map", qos_profile=latched())
    node.create_subscription(Vector3, "map", got.append, qos_profile=latched())
    drain(backend)
    assert got == [Vector3()]


def test_kept_messages_for_which_a_subscription_has_no_room_are_not_counted_as_dropped(
    backend: LocalBackend,
) -> None:
    publish(backend.create_publisher(Vector3, "map", latched(5)), *range(5))
    got: list[Vector3] = []
    subscription = backend.create_subscription(Vector3, "map", got.append, latched(2))
    drain(backend)
    assert [message.x for message in got] == [3, 4]
    assert subscription.dropped == 0


def test_a_message_that_was_refused_is_not_kept(backend: LocalBackend) -> None:
    publisher = backend.create_publisher(Vector3, "map", latched())
    with pytest.raises(TypeError, match="/map takes Vector3, not str"):
        publisher.publish("map")  # type: ignore[arg-type]  # the mistake is the test
    late = subscribe(backend, latched())
    drain(backend)
    assert late == []


def test_a_destroyed_latched_subscription_is_not_called_with_what_was_kept(
    backend: LocalBackend,
) -> None:
    publisher = backend.create_publisher(Vector3, "map", latched())
    publish(publisher, 1)
    got: list[Vector3] = []
    subscription = backend.create_subscription(Vector3, "map", got.append, latched())
    backend.destroy_subscription(subscription)
    publish(publisher, 2)
    drain(backend)
    assert got == []


@define
class Heard:
    """What a subscription should have got: queued up to its depth, then handled."""

    profile: QoSProfile
    waiting: list[int] = field(factory=list)
    got: list[int] = field(factory=list)

    def take(self, offered: QoSProfile, *numbers: int) -> None:
        if offered.is_latched or not self.profile.is_latched:
            self.waiting = [*self.waiting, *numbers][-self.profile.queue_depth :]

    def handle(self) -> None:
        self.got += self.waiting
        self.waiting = []


@given(qos_profiles, qos_profiles, qos_steps)
def test_who_comes_late_gets_what_a_small_model_says(
    one: QoSProfile, two: QoSProfile, steps: list[QosStep]
) -> None:
    backend = virtual_backend()
    offered = (one, two)
    publishers = [backend.create_publisher(Vector3, "map", profile) for profile in offered]
    kept: list[list[int]] = [[], []]
    subscriptions: list[tuple[list[int], Heard]] = []
    for number, step in enumerate(steps):
        if isinstance(step, QoSProfile):
            heard = Heard(step)
            subscriptions.append((subscribe(backend, step), heard))
            for profile, messages in zip(offered, kept, strict=True):
                if profile.is_latched and step.is_latched:
                    heard.take(profile, *messages[-profile.queue_depth :])
        elif step is None:
            drain(backend)
            for _, heard in subscriptions:
                heard.handle()
        else:
            publish(publishers[step], number)
            kept[step].append(number)
            for _, heard in subscriptions:
                heard.take(offered[step], number)
    drain(backend)
    for got, heard in subscriptions:
        heard.handle()
        assert got == heard.got
    backend.close()


def test_nothing_is_lost_or_twice_for_who_comes_while_another_thread_publishes(
    backend: LocalBackend,
) -> None:
    publisher = backend.create_publisher(Vector3, "map", latched(3))
    ending = threading.Event()
    sent: list[int] = []

    def publish_on() -> None:
        while not ending.is_set():
            publish(publisher, len(sent))
            sent.append(len(sent))

    thread = threading.Thread(target=publish_on)
    thread.start()
    try:
        late = []
        for _ in range(30):
            seen = len(sent)
            wait_until(lambda n=seen: len(sent) > n, "a message")  # type: ignore[misc]  # mypy infers no default of a lambda
            late.append(subscribe(backend, latched(history=HistoryPolicy.KEEP_ALL)))
    finally:
        ending.set()
        thread.join()
    drain(backend)
    for got in late:
        assert got == list(range(got[0], len(sent)))


@pytest.mark.parametrize(
    ("offered", "asked", "reason"),
    [
        (BEST_EFFORT, QoSProfile(), "it asks for RELIABLE and the publisher offers BEST_EFFORT"),
        (QoSProfile(), latched(), "it asks for TRANSIENT_LOCAL and the publisher offers VOLATILE"),
    ],
    ids=["reliability", "durability"],
)
def test_a_publisher_that_offers_less_than_is_asked_for_is_not_heard_and_one_line_says_why(
    backend: LocalBackend,
    caplog: pytest.LogCaptureFixture,
    offered: QoSProfile,
    asked: QoSProfile,
    reason: str,
) -> None:
    before = subscribe(backend, asked)
    publisher = backend.create_publisher(Vector3, "map", offered)
    after = subscribe(backend, asked)
    publish(publisher, 1)
    drain(backend)
    assert (before, after) == ([], [])
    assert caplog.messages == [f"/map: a subscription gets nothing from a publisher: {reason}"]
    # And the other way round, where more is offered than asked for, it is.
    strong = backend.create_publisher(Vector3, "map", asked)
    weak = subscribe(backend, offered)
    publish(strong, 2)
    drain(backend)
    assert (before, after, weak) == ([2], [2], [2])
    assert len(caplog.messages) == 1


def test_a_depth_and_a_history_never_keep_two_apart() -> None:
    profiles = [QoSProfile(1), QoSProfile(1000), KEEP_ALL]
    assert {mismatch(offered, asked) for offered in profiles for asked in profiles} == {""}
