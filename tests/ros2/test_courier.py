"""Messages of one's own, and messages that are bytes on their way."""

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import pytest
from attrs import frozen
from test_msgs.msg import BasicTypes as RosBasicTypes

from rosbase import wire
from rosbase.messages import Imu, PointCloud2, TFMessage
from rosbase.messages import fields as ros
from rosbase.messages.fields import message
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.conversion import Conversions
from rosbase_ros2.courier import courier_of
from support.ros import spin_until


@message("test_msgs/msg/BasicTypes")
@dataclass(frozen=True)
class Basic:
    """The class of a program, with the fields of that message."""

    bool_value: bool = False
    byte_value: ros.Byte = 0
    char_value: ros.Char = 100
    float32_value: ros.Float32 = 1.125
    float64_value: float = 1.125
    int8_value: ros.Int8 = -50
    uint8_value: ros.UInt8 = 200
    int16_value: ros.Int16 = -1000
    uint16_value: ros.UInt16 = 2000
    int32_value: ros.Int32 = -30000
    uint32_value: ros.UInt32 = 60000
    int64_value: ros.Int64 = -40000000
    uint64_value: ros.UInt64 = 50000000


@message("test_msgs/msg/Strings")
@frozen
class OtherStrings:
    string_value: str = ""
    string_value_default1: Annotated[str, ros.AtMost(5)] = ""


def publish_until(backend: Ros2Backend, publish: Any, got: list[Any]) -> None:
    timer = backend.create_timer(0.02, publish)
    spin_until(backend, lambda: got)
    backend.destroy_timer(timer)


def test_a_message_of_ones_own_meets_its_ros_message_on_a_topic(backend: Ros2Backend) -> None:
    native: list[Any] = []
    own: list[Basic] = []
    backend.create_subscription(RosBasicTypes, "basic", native.append, 10)
    backend.create_subscription(Basic, "basic", own.append, 10)
    sent = Basic(bool_value=True, uint64_value=2**64 - 1, float32_value=0.5)
    publish_until(backend, partial(backend.create_publisher(Basic, "basic", 10).publish, sent), own)
    spin_until(backend, lambda: native)
    assert own[0] == sent
    assert (native[0].uint64_value, native[0].float32_value) == (2**64 - 1, 0.5)


def test_a_class_whose_bytes_would_be_others_is_refused_with_the_field() -> None:
    with pytest.raises(
        TypeError,
        match=r"^OtherStrings differs from test_msgs/msg/Strings of ROS: it has string<5>"
        r" string_value_default1, where ROS has string string_value_default1$",
    ):
        courier_of(OtherStrings, Conversions())


@message("no_such_msgs/msg/Thing")
@frozen
class Thing:
    pass


@message("std_msgs/msg/NoSuchMessage")
@frozen
class NoSuchMessage:
    pass


def test_a_message_that_ros_does_not_have_is_refused_with_what_to_install(
    backend: Ros2Backend,
) -> None:
    with pytest.raises(TypeError, match=r"not installed: pip install ros-jazzy-no-such-msgs, or"):
        backend.create_publisher(Thing, "thing", 10)
    with pytest.raises(TypeError, match=r"tf2_msgs is not installed: source a workspace that"):
        backend.create_publisher(TFMessage, "tf", 10)
    with pytest.raises(TypeError, match=r"std_msgs has no NoSuchMessage$"):
        backend.create_subscription(NoSuchMessage, "thing", print, 10)


def test_bytes_that_are_no_message_are_dropped_and_said_and_the_next_one_arrives(
    backend: Ros2Backend, caplog: pytest.LogCaptureFixture
) -> None:
    got: list[Imu] = []
    backend.create_subscription(Imu, "imu", got.append, 100)
    publisher: Any = backend.create_publisher(Imu, "imu", 100)

    def send_both() -> None:
        publisher.inner.publish(wire.serialize(Imu())[:40])
        publisher.publish(Imu())

    publish_until(backend, send_both, got)
    assert got[0] == Imu()
    spin_until(backend, lambda: caplog.records)
    assert caplog.records[0].levelname == "WARNING"
    assert caplog.messages[0].startswith("/imu: dropped a message: sensor_msgs/msg/Imu: ")


def test_a_cloud_arrives_as_a_view_of_what_was_received(backend: Ros2Backend) -> None:
    got: list[PointCloud2] = []
    backend.create_subscription(PointCloud2, "cloud", got.append, 10)
    sent = PointCloud2(width=1000, data=bytes(range(250)) * 64)
    publish_until(
        backend, partial(backend.create_publisher(PointCloud2, "cloud", 10).publish, sent), got
    )
    assert got[0] == sent
    assert isinstance(got[0].data, memoryview)
    assert got[0].data.readonly


def test_bounds_are_those_of_ros() -> None:
    @message("test_msgs/msg/BoundedSequences")
    @frozen
    class TooFew:
        bool_values: Annotated[tuple[bool, ...], ros.AtMost(2)] = ()

    with pytest.raises(TypeError, match=r"sequence<boolean, 2>.*sequence<boolean, 3>"):
        courier_of(TooFew, Conversions())
