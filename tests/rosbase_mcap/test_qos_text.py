"""Profiles as `ros2 bag` reads them."""

from rosbase import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbase_mcap.qos_text import profiles_text

# What rosbag2 writes beside a topic.
OF_ROSBAG2 = """\
- history: 1
  depth: 1
  reliability: 2
  durability: 1
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: 1
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false"""


def test_a_profile_has_the_numbers_of_rmw() -> None:
    reliability, durability = ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.TRANSIENT_LOCAL
    profile = QoSProfile(1, reliability=reliability, durability=durability)
    assert profiles_text([profile]) == OF_ROSBAG2


def test_profiles_of_several_publishers_are_a_list_without_repeats() -> None:
    text = profiles_text([QoSProfile(1), QoSProfile(2), QoSProfile(1)])
    assert text.count("- history") == 2


def test_a_history_that_keeps_all_has_no_depth() -> None:
    assert "history: 2\n  depth: 0" in profiles_text([QoSProfile(history=HistoryPolicy.KEEP_ALL)])


def test_no_profile_is_no_text() -> None:
    assert profiles_text([]) == ""
