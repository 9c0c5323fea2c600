"""Fields that are tuples, and those of a time: what else they are given becomes one."""

from array import array
from typing import Any

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.messages import (
    CameraInfo,
    DiagnosticStatus,
    Duration,
    Header,
    Imu,
    JointState,
    Joy,
    KeyValue,
    Marker,
    Time,
)
from rosbase.messages.fields import fixed, is_frozen, message, sequence
from rosbase.messages.rcl_interfaces import ParameterValue
from rosbase.messages.trajectory_msgs import JointTrajectoryPoint
from rosbase.testing import virtual_backend
from rosbase.wire import deserialize, serialize
from rosbase.wire.description import Kind, describe
from support.wire_messages import CLASSES, Rolled, made, name_of

WHOLE = st.integers(0, 100)


def forms_of(numbers: list[Any]) -> list[Any]:
    """The same numbers as programs for rclpy have them."""
    return [
        numbers,
        tuple(numbers),
        np.array(numbers, np.float64),
        np.array(numbers, np.int64),
        np.array(numbers, ">i2"),
        np.array(numbers, np.float32)[::1],
        array("d", numbers),
        array("l", numbers),
        memoryview(array("i", numbers)),
    ]


@given(st.lists(WHOLE, max_size=4))
def test_a_list_or_an_array_becomes_a_tuple_of_pythons_own_numbers(numbers: list[int]) -> None:
    for form in forms_of(numbers):
        for state in (JointState(position=form), attrs.evolve(JointState(), position=form)):
            assert type(state.position) is tuple
            assert {type(number) for number in state.position} <= {int, float}
            assert state == JointState(position=tuple(numbers))
            assert hash(state) == hash(JointState(position=tuple(numbers)))
            assert deserialize(serialize(state), JointState) == state
        if np.asarray(form).dtype.kind == "i":
            sent = Joy(buttons=form)
            assert deserialize(serialize(sent), Joy).buttons == tuple(numbers)


@given(st.lists(WHOLE, min_size=9, max_size=9))
def test_an_array_of_a_fixed_size_too(numbers: list[int]) -> None:
    for form in forms_of(numbers):
        imu = Imu(orientation_covariance=form)
        nine: Any = tuple(numbers)
        assert imu == Imu(orientation_covariance=nine)
        assert hash(imu) == hash(deserialize(serialize(imu), Imu))
    wrongs: list[Any] = [numbers[:8], np.zeros(10)]
    for wrong in wrongs:
        with pytest.raises(ValueError, match=r"^orientation_covariance takes 9 elements, not "):
            Imu(orientation_covariance=wrong)


@pytest.mark.parametrize("cls", [cls for cls in CLASSES if describe(cls).fields], ids=name_of)
def test_no_message_keeps_a_list_that_it_was_given(cls: type) -> None:
    choose = Rolled(7)
    for _ in range(5):
        sent = made(describe(cls), choose)
        fields = [one for one in describe(cls).fields if one.kind is not Kind.ONE]
        tuples = [one for one in fields if not one.is_buffer]
        lists = {one.alias: list(getattr(sent, one.name)) for one in tuples}
        other = attrs.evolve(sent, **lists)
        for given_list in lists.values():
            given_list.clear()
        assert serialize(other) == serialize(sent)
        for one in tuples:
            assert type(getattr(other, one.name)) is tuple


def test_one_list_that_is_filled_again_arrives_as_it_was_each_time() -> None:
    backend = virtual_backend()
    got: list[Any] = []
    backend.create_subscription(JointState, "joints", got.append, 10)
    publisher = backend.create_publisher(JointState, "joints", 10)
    position: Any = [0.0]
    for number in range(4):
        position[0] = float(number)
        publisher.publish(JointState(position=position))
    while backend.spin_once(0.0):
        pass
    assert [state.position for state in got] == [(0.0,), (1.0,), (2.0,), (3.0,)]
    backend.close()


@pytest.mark.parametrize(
    ("wrong", "kind"),
    [
        ("hip", "str"),
        (b"ab", "bytes"),
        (bytearray(2), "bytearray"),
        (None, "NoneType"),
        (1.0, "float"),
        ({"hip"}, "set"),
        (iter(()), "tuple_iterator"),
        (np.zeros((2, 2)), "one of 2 dimensions"),
        (np.float64(1.0), "one of 0 dimensions"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_is_no_sequence_is_refused_by_the_name_of_the_field(wrong: Any, kind: str) -> None:
    takes = f"takes a tuple, a list or an array of one dimension, not {kind}$"
    with pytest.raises(TypeError, match=f"^position {takes}"):
        JointState(position=wrong)
    with pytest.raises(TypeError, match=f"^k {takes}"):
        CameraInfo(k=wrong)


def test_bytes_are_taken_where_ros_has_bytes() -> None:
    data: Any = b"ab"
    value = ParameterValue(byte_array_value=data)
    assert value.byte_array_value == (97, 98)
    assert deserialize(serialize(value), ParameterValue) == value


def test_messages_in_a_list_become_a_tuple_of_them() -> None:
    values: Any = [KeyValue("a", "1")]
    status = DiagnosticStatus(values=values)
    assert status == DiagnosticStatus(values=(KeyValue("a", "1"),))
    assert hash(status) == hash(deserialize(serialize(status), DiagnosticStatus))


def test_fields_of_own_messages_can_do_the_same() -> None:
    @message("my_msgs/msg/Own")
    @attrs.frozen
    class Own:
        any_number: tuple[float, ...] = sequence()
        two: tuple[float, float] = fixed(2)

    assert is_frozen(Own)
    one: Any = Own
    assert one([1.0], np.array([2.0, 3.0])) == Own((1.0,), (2.0, 3.0))


class Stamp:  # noqa: PLW1641 - as a message of ROS
    """As in ROS: it can be changed, and has no hash."""

    def __init__(self, sec: int, nanosec: int) -> None:
        self.sec, self.nanosec = sec, nanosec

    def __eq__(self, other: object) -> bool:
        return self is other


RosTime, RosDuration = type("Time", (Stamp,), {}), type("Duration", (Stamp,), {})


@given(st.integers(0, 2**31 - 1), st.integers(0, 999_999_999))
def test_a_time_of_ros_becomes_one_of_rosbase(sec: int, nanosec: int) -> None:
    theirs: Any = RosTime(sec, nanosec)
    header = Header(theirs, "map")
    assert header == Header(Time(sec, nanosec), "map")
    assert hash(header) == hash(Header(Time(sec, nanosec), "map"))
    theirs.sec = 0
    assert (header.stamp.sec, header.stamp.nanosec) == (sec, nanosec)
    their_length: Any = RosDuration(sec, nanosec)
    for kind, name in ((JointTrajectoryPoint, "time_from_start"), (Marker, "lifetime")):
        made_of: Any = kind
        assert getattr(made_of(**{name: their_length}), name) == Duration(sec, nanosec)
        assert type(getattr(made_of(**{name: their_length}), name)) is Duration


def test_what_is_no_time_stays_and_is_refused_when_it_is_written() -> None:
    wrongs: list[Any] = [None, 1.5, Duration(1), "now"]
    for wrong in wrongs:
        header = Header(wrong)
        assert header.stamp is wrong
    with pytest.raises(TypeError, match=r"^Header\.stamp takes messages of type Time, not None$"):
        serialize(Header(wrongs[0]))
