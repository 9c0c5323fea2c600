from importlib import import_module
from typing import Any

import attrs
import pytest
from hypothesis import example, given

from rosbase.imu.outlet import VARYING
from rosbase.messages import Header, Imu, MagneticField, Quaternion, Time, Twist, Vector3
from rosbase.wire import packer, writer
from rosbase_ros2.conversion import Conversions
from support import strategies

serialization: Any = import_module("rclpy.serialization")

WRITERS: dict[type, Any] = {kind: writer(kind) for kind in (Imu, MagneticField)}
CONVERSIONS = Conversions()

extreme = Header(Time(-(2**31), 2**32 - 1), "")


def by_ros(message: Any) -> bytes:
    """What ROS makes of it, with zeros in the padding, where ROS leaves what was in memory."""
    data = bytearray(serialization.serialize_message(CONVERSIONS.of(type(message)).to_ros(message)))
    end_of_text = 4 + 8 + 4 + len(message.header.frame_id.encode()) + 1
    padding = -(end_of_text - 4) % 8
    data[end_of_text : end_of_text + padding] = bytes(padding)
    return bytes(data)


@given(strategies.messages[Imu] | strategies.messages[MagneticField])
@example(Imu(extreme))
@example(MagneticField(extreme))
@example(Imu(Header(Time(2**31 - 1, 0), "gerät/イミュ/🧭")))
def test_the_bytes_are_those_of_ros(message: Any) -> None:
    assert WRITERS[type(message)](message) == by_ros(message)


@given(strategies.messages[Imu])
def test_a_sample_is_sent_as_the_message_with_its_numbers_would_be(imu: Imu) -> None:
    template = attrs.evolve(imu, header=Header(frame_id=imu.header.frame_id))
    sample = [
        attrs.astuple(part)
        for part in (imu.orientation, imu.angular_velocity, imu.linear_acceleration)
    ]
    stamp_ns = imu.header.stamp.nanoseconds % (2**31 * 10**9)
    whole = attrs.evolve(imu, header=Header(Time.from_nanoseconds(stamp_ns), imu.header.frame_id))
    assert packer(template, VARYING)(stamp_ns, *sample) == by_ros(whole)


@pytest.mark.parametrize("length", range(17))
def test_the_numbers_stand_where_ros_looks_for_them_for_every_length_of_the_frame(
    length: int,
) -> None:
    for kind in (Imu, MagneticField):
        message = kind(Header(Time(1, 2), "f" * length))
        data = WRITERS[kind](message)
        converter = CONVERSIONS.of(kind)
        back = serialization.deserialize_message(data, converter.ros_type)
        assert converter.from_ros(back) == message


def test_whole_numbers_are_sent_as_floats() -> None:
    whole = Imu(orientation=Quaternion(1, 0, 0, 0), linear_acceleration_covariance=(1,) * 9)
    same = Imu(
        orientation=Quaternion(1.0, 0.0, 0.0, 0.0), linear_acceleration_covariance=(1.0,) * 9
    )
    for _ in range(2):
        assert WRITERS[Imu](whole) == WRITERS[Imu](same) == by_ros(whole)


QUANTITIES = [
    (kind, field.name) for kind in WRITERS for field in attrs.fields(kind) if field.name != "header"
]


@pytest.mark.parametrize("value", [True, None, "1.0", 1j], ids=repr)
@pytest.mark.parametrize(("kind", "name"), QUANTITIES)
def test_a_value_that_is_no_number_is_refused_by_the_name_of_its_field(
    kind: type, name: str, value: Any
) -> None:
    write = WRITERS[kind]
    good = kind(Header(frame_id="imu_link"))
    write(good)
    quantity = getattr(good, name)
    if isinstance(quantity, tuple):
        faults = [(name, (*quantity[:i], value, *quantity[i + 1 :])) for i in range(9)]
    else:
        axes = [field.name for field in attrs.fields(type(quantity))]
        faults = [(f"{name}.{axis}", attrs.evolve(quantity, **{axis: value})) for axis in axes]
    for where, faulty in faults:
        with pytest.raises(TypeError, match=rf"^{kind.__name__}\.{where} takes numbers, not "):
            write(attrs.evolve(good, **{name: faulty}))


@pytest.mark.parametrize("kind", list(WRITERS))
@pytest.mark.parametrize(
    ("header", "error", "where"),
    [
        (Header(Time(2**31, 0)), ValueError, "header.stamp.sec"),
        (Header(Time(-(2**31) - 1, 0)), ValueError, "header.stamp.sec"),
        (Header(Time(0, 2**32)), ValueError, "header.stamp.nanosec"),
        (Header(Time(0, -1)), ValueError, "header.stamp.nanosec"),
        (Header(Time(True, 0)), TypeError, "header.stamp.sec"),
        (Header(Time(0, 1.0)), TypeError, "header.stamp.nanosec"),  # type: ignore[arg-type]  # the mistake is the test
        (Header(Time(), "a\0b"), ValueError, "header.frame_id"),
        (Header(Time(), "\ud800"), ValueError, "header.frame_id"),
        (Header(Time(), None), TypeError, "header.frame_id"),  # type: ignore[arg-type]  # the mistake is the test
        (Header(Time(), ["a"]), TypeError, "header.frame_id"),  # type: ignore[arg-type]  # the mistake is the test
        (Header(None), TypeError, "header.stamp"),  # type: ignore[arg-type]  # the mistake is the test
        (None, TypeError, "header"),
    ],
)
def test_a_header_that_ros_cannot_send_is_refused_in_one_line(
    kind: type, header: Any, error: type[Exception], where: str
) -> None:
    WRITERS[kind](kind())
    with pytest.raises(error, match=rf"^{kind.__name__}\.{where} takes [^\n]*$"):
        WRITERS[kind](kind(header))


def test_another_message_in_the_place_of_a_quantity_is_refused() -> None:
    write = WRITERS[Imu]
    with pytest.raises(TypeError, match=r"^Imu\.orientation takes messages of type Quaternion"):
        write(Imu(orientation=Vector3()))  # type: ignore[arg-type]  # the mistake is the test
    for wrong in (Twist(), MagneticField(), None):
        with pytest.raises(TypeError, match=r"^Imu takes messages of type Imu, not "):
            write(wrong)


def test_a_covariance_of_another_size_is_refused() -> None:
    with attrs.validators.disabled():
        imu = Imu(orientation_covariance=(1.0,) * 8)  # type: ignore[arg-type]  # the mistake is the test
    with pytest.raises(ValueError, match=r"^Imu\.orientation_covariance takes 9 elements, not 8$"):
        WRITERS[Imu](imu)
