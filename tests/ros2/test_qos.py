"""Quality of service on real rclpy: our profiles on this side, plain rclpy on the other."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from rclpy import qos as ros
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String as RosString

from rosbase.contracts.backend import BackendOptions
from rosbase.messages import String
from rosbase.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.qos import queue_depth, to_profile
from support.waiting import wait_until

LATCHED = QoSProfile(2, durability=DurabilityPolicy.TRANSIENT_LOCAL)
ROS_LATCHED = ros.QoSProfile(depth=2, durability=ros.DurabilityPolicy.TRANSIENT_LOCAL)


class Pair:
    """A backend, and a node of plain rclpy; both are spun while somebody waits."""

    def __init__(self, context: Any) -> None:
        self.backend = Ros2Backend(BackendOptions("ours"))
        self.node: Any = rclpy.create_node("plain", context=context)
        self._executor: Any = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)

    def spin_until(self, is_done: Callable[[], object]) -> None:
        def turn() -> object:
            self._executor.spin_once(timeout_sec=0.01)
            self.backend.spin_once(0.01)
            return is_done()

        wait_until(turn, "the other side")

    def close(self) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        self.backend.close()


@pytest.fixture
def pair(context: Any) -> Iterator[Pair]:
    pair = Pair(context)
    yield pair
    pair.close()


def test_the_profiles_of_rosbase_are_by_default_those_of_ros() -> None:
    assert to_profile(QoSProfile(), "words") == ros.qos_profile_default
    assert to_profile(qos_profile_sensor_data, "words") == ros.qos_profile_sensor_data
    assert to_profile(7, "words") == ros.QoSProfile(depth=7)


@pytest.mark.parametrize("reliability", ReliabilityPolicy)
@pytest.mark.parametrize("durability", DurabilityPolicy)
@pytest.mark.parametrize("history", HistoryPolicy)
def test_each_policy_becomes_the_one_of_that_name(
    reliability: ReliabilityPolicy, durability: DurabilityPolicy, history: HistoryPolicy
) -> None:
    policies: Any = {"reliability": reliability, "durability": durability, "history": history}
    profile = to_profile(QoSProfile(3, **policies), "words")
    assert profile.depth == 3
    for name, policy in policies.items():
        assert getattr(profile, name).name == policy.name
    assert (queue_depth(profile) == 3) == (history is HistoryPolicy.KEEP_LAST)


def test_a_history_that_keeps_all_needs_no_depth(pair: Pair) -> None:
    nothing: Any = None
    profile = QoSProfile(nothing, history=HistoryPolicy.KEEP_ALL)
    got: list[String] = []
    pair.backend.create_subscription(String, "words", got.append, profile)
    publisher = pair.backend.create_publisher(String, "words", profile)
    pair.spin_until(lambda: publisher.publish(String("x")) and got)


def test_the_policies_of_rclpy_make_a_profile_of_rosbase() -> None:
    policy: Any = ros.DurabilityPolicy.TRANSIENT_LOCAL
    assert QoSProfile(2, durability=policy) == LATCHED


def test_a_later_subscription_of_plain_rclpy_gets_what_a_latched_publisher_of_ours_kept(
    pair: Pair,
) -> None:
    got: list[str] = []
    publisher = pair.backend.create_publisher(String, "map", LATCHED)
    for word in ("one", "two", "three"):
        publisher.publish(String(word))
    pair.node.create_subscription(RosString, "map", lambda m: got.append(m.data), ROS_LATCHED)
    pair.spin_until(lambda: len(got) == 2)
    assert got == ["two", "three"]


def test_a_later_latched_subscription_of_ours_gets_what_plain_rclpy_kept(pair: Pair) -> None:
    got: list[str] = []
    publisher = pair.node.create_publisher(RosString, "map", ROS_LATCHED)
    for word in ("one", "two", "three"):
        publisher.publish(RosString(data=word))
    pair.backend.create_subscription(String, "map", lambda m: got.append(m.data), LATCHED)
    pair.spin_until(lambda: len(got) == 2)
    assert got == ["two", "three"]


def test_a_pair_that_does_not_match_is_said_by_rclpy_once_on_either_end_of_ours(
    pair: Pair, capfd: pytest.CaptureFixture[str]
) -> None:
    pair.backend.create_publisher(String, "offered", qos_profile_sensor_data)
    pair.node.create_subscription(RosString, "offered", lambda message: None, 10)
    pair.backend.create_subscription(String, "asked", print, LATCHED)
    pair.node.create_publisher(RosString, "asked", 10)
    said: list[str] = []

    def warnings_of(topic: str) -> int:
        said.append(capfd.readouterr().err)
        lines = "".join(said).splitlines()
        return sum("[ours]" in line and f"'{topic}'" in line for line in lines)

    pair.spin_until(lambda: warnings_of("offered") and warnings_of("asked"))
    assert (warnings_of("offered"), warnings_of("asked")) == (1, 1)
    assert "requesting incompatible QoS" in "".join(said)
    assert "Last incompatible policy: DURABILITY" in "".join(said)
