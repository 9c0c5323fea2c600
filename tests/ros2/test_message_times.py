"""Our times and durations beside those of rclpy, and beside the messages of ROS."""

from typing import Any

import builtin_interfaces.msg
import rclpy.clock
import rclpy.duration
import rclpy.time
import std_msgs.msg
from hypothesis import given
from hypothesis import strategies as st
from trajectory_msgs.msg import JointTrajectoryPoint

from rosbase.messages import Duration, Header, Time
from rosbase.wire import deserialize, serialize

S = 1_000_000_000
# rclpy has no times before 1970.
stamps = st.integers(0, 2**31 * S - 1)


def forms_of_time(count: int) -> list[Any]:
    theirs: Any = rclpy.time.Time(nanoseconds=count)
    return [Time.from_nanoseconds(count), theirs, theirs.to_msg()]


def forms_of_duration(count: int) -> list[Any]:
    theirs: Any = rclpy.duration.Duration(nanoseconds=count)
    return [Duration.from_nanoseconds(count), theirs, theirs.to_msg()]


@given(stamps, stamps)
def test_times_are_computed_with_on_either_side(a: int, b: int) -> None:
    time, duration = Time.from_nanoseconds(a), Duration.from_nanoseconds(a)
    for other in forms_of_time(b):
        assert (time - other).nanoseconds == a - b
        assert (other - time).nanoseconds == b - a
        assert (other + duration).nanoseconds == (duration + other).nanoseconds == a + b
        assert (other - duration).nanoseconds == b - a
    for other in forms_of_duration(b):
        assert (time + other).nanoseconds == (other + time).nanoseconds == a + b
        assert (time - other).nanoseconds == (duration - other).nanoseconds == a - b
        assert (duration + other).nanoseconds == (other + duration).nanoseconds == a + b
        assert (other - duration).nanoseconds == b - a


@given(stamps, stamps)
def test_times_are_compared_on_either_side(a: int, b: int) -> None:
    for forms, own in (
        (forms_of_time, Time.from_nanoseconds(a)),
        (forms_of_duration, Duration.from_nanoseconds(a)),
    ):
        same: Any = own
        for other in forms(b):
            assert (same < other, other > same) == (a < b, a < b)
            assert (same <= other, other >= same) == (a <= b, a <= b)
            assert (same == other, same != other) == (a == b, a != b)
            # A message of ROS calls everything of another class different.
            if not hasattr(other, "get_fields_and_field_types"):
                assert (other == same, other != same) == (a == b, a != b)


def test_a_time_of_ros_may_be_the_stamp_of_our_header() -> None:
    stamp: Any = builtin_interfaces.msg.Time(sec=3, nanosec=4)
    assert serialize(Header(stamp, "map")) == serialize(Header(Time(3, 4), "map"))
    assert Header(Time(3, 4), "map") == Header(stamp, "map")
    assert hash(Header(Time(3, 4), "map")) == hash(Header(stamp, "map"))


@given(st.integers(0, 2**30 * S), st.integers(0, 2**29 * S))
def test_whatever_was_computed_may_be_a_field_of_a_ros_message(a: int, b: int) -> None:
    time, length = Time.from_nanoseconds(a + b), Duration.from_nanoseconds(b)
    header: Any = std_msgs.msg.Header
    # The setters check: the tests run with ROS_PYTHON_CHECK_FIELDS.
    for other in forms_of_duration(b):
        for computed, count in ((time + other, a + b + b), (time - other, a), (other + time, None)):
            ros = header(stamp=computed.to_msg())
            assert count is None or ros.stamp == rclpy.time.Time(nanoseconds=count).to_msg()
            own = Header(computed)
            assert rclpy.time.Time.from_msg(own.stamp.to_msg()).nanoseconds == own.stamp.nanoseconds
    for other in forms_of_time(a):
        for computed in (time - other, length + length, length - length, -length):
            point = JointTrajectoryPoint(time_from_start=computed.to_msg())
            assert point.time_from_start.sec == computed.sec
            assert point.time_from_start.nanosec == computed.nanosec
        assert header(stamp=(other + length).to_msg()).stamp == time.to_msg()


def test_a_stamp_that_was_received_may_be_a_field_of_a_ros_message() -> None:
    received = deserialize(serialize(Header(Time(3, 4), "map")), Header)
    header: Any = std_msgs.msg.Header
    assert header(stamp=received.stamp.to_msg()).stamp.nanosec == 4


def test_fields_of_ros_are_checked_throughout_these_tests() -> None:
    header: Any = std_msgs.msg.Header
    try:
        header(frame_id=3)
    except AssertionError:
        return
    raise AssertionError("a wrong field of a ROS message was not noticed")
