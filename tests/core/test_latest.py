"""The latest message of a topic, and its age."""

import math
from collections.abc import Iterator
from typing import Any

import pytest

from rosbase import BaseHandlers, BaseManager, BaseNode, LocalBackend
from rosbase.messages import Header, Point, Time
from rosbase.testing import ManualClock, virtual_backend


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def node(clock: ManualClock) -> Iterator[BaseNode]:
    node = BaseNode(backend=virtual_backend(clock))
    yield node
    node.destroy_node()


def handle_all(node: BaseNode) -> None:
    while node._backend.spin_once(0.0):
        pass


def send(node: BaseNode, *numbers: float) -> None:
    publisher = node.create_publisher(Point, "position")
    for number in numbers:
        publisher.publish(Point(number))
    node.destroy_publisher(publisher)
    handle_all(node)


def test_before_the_first_message_there_is_no_value_and_nothing_is_fresh_or_new(
    node: BaseNode,
) -> None:
    position = node.latest(Point, "position")
    assert position.value is None
    assert position.age_s == math.inf
    assert not position.is_fresh(math.inf)
    assert not position.is_new()


def test_the_value_is_the_latest_of_several_messages(node: BaseNode) -> None:
    position = node.latest(Point, "position")
    send(node, 1.0, 2.0, 3.0)
    assert position.value == Point(3.0)
    send(node, 4.0)
    assert position.value == Point(4.0)


def test_each_new_message_is_new_once(node: BaseNode) -> None:
    position = node.latest(Point, "position")
    send(node, 1.0)
    assert [position.is_new(), position.is_new()] == [True, False]
    send(node, 2.0, 3.0)
    assert [position.is_new(), position.is_new()] == [True, False]


def test_the_same_object_again_is_a_new_message(node: BaseNode) -> None:
    publisher, position = node.create_publisher(Point, "position"), node.latest(Point, "position")
    message = Point(1.0)
    for _ in range(2):
        publisher.publish(message)
        handle_all(node)
        assert position.is_new()


def test_the_age_counts_from_the_arrival_and_not_from_the_stamp(
    node: BaseNode, clock: ManualClock
) -> None:
    header = node.latest(Header, "header")
    node.create_publisher(Header, "header").publish(Header(Time(sec=5)))
    handle_all(node)
    assert header.age_s == 0.0
    clock.advance(0.25)
    assert header.age_s == header.time_since_last_msg() == pytest.approx(0.25)


def test_a_message_is_fresh_up_to_and_including_the_timeout(
    node: BaseNode, clock: ManualClock
) -> None:
    position = node.latest(Point, "position")
    send(node, 1.0)
    clock.advance(0.5)
    assert position.is_fresh(0.5)
    clock.advance(0.01)
    assert not position.is_fresh(0.5)
    assert position.value == Point(1.0)


def test_a_date_that_is_set_does_not_change_the_age(node: BaseNode, clock: ManualClock) -> None:
    position = node.latest(Point, "position")
    send(node, 1.0)
    clock.date_ns += 3_600_000_000_000
    assert position.age_s == 0.0


def test_a_time_that_was_set_back_makes_no_message_fresh() -> None:
    class Restarted(LocalBackend):
        now_ns = 10_000_000_000

        def timer_now_ns(self) -> int:
            return self.now_ns

    virtual = virtual_backend()
    backend = Restarted(virtual._options, virtual._bus)
    node = BaseNode(backend=backend)
    position = node.latest(Point, "position")
    send(node, 1.0)
    backend.now_ns = 0
    assert position.age_s == math.inf
    assert not position.is_fresh(60.0)
    node.destroy_node()
    virtual.close()


def test_the_subscription_keeps_one_message_and_can_be_destroyed(node: BaseNode) -> None:
    position = node.latest(Point, "position")
    assert position.subscription.topic == "/position"
    publisher = node.create_publisher(Point, "position")
    for number in range(3):
        publisher.publish(Point(float(number)))
    handle_all(node)
    assert position.subscription.dropped == 2
    node.destroy_subscription(position.subscription)
    send(node, 5.0)
    assert position.value == Point(2.0)


def test_the_repr_has_the_topic_and_the_age(node: BaseNode, clock: ManualClock) -> None:
    position = node.latest(Point, "position")
    assert repr(position) == "<Latest of /position: no message>"
    send(node, 1.0)
    clock.advance(1.5)
    assert repr(position) == "<Latest of /position: age 1.5 s>"


def test_handlers_see_in_virtual_time_that_a_source_falls_silent() -> None:
    seen: list[tuple[float, bool, bool]] = []

    class Robot(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.position = self.latest(Point, "position")
            self.sender = self.create_publisher(Point, "position")

    class Handlers(BaseHandlers):
        def handle(self) -> None:
            position = self.node(Robot).position
            if self.timestamp == 0:
                self.node(Robot).sender.publish(Point(1.0))
            seen.append((round(position.age_s, 6), position.is_fresh(0.25), position.is_new()))
            if self.timestamp == 4:
                self.manager.request_stop()

    manager = BaseManager(
        nodes_dict={"robot": Robot},
        handlers_class=Handlers,
        node_freq_hz=10,
        backend=virtual_backend(),
    )
    manager.start_main_loop_timer()
    assert seen == [
        (math.inf, False, False),
        (0.1, True, True),
        (0.2, True, False),
        (0.3, False, False),
        (0.4, False, False),
    ]
