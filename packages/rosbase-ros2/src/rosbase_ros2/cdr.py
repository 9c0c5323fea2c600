"""Samples as the bytes that DDS sends, for a publisher that takes them ready-made.

A ROS message that is built and then serialised costs many times as much. The layout is CDR,
little-endian: OMG DDS-RTPS 2.3, section 10 (the four bytes in front), and CORBA 3.3, part 2,
section 9.3 (a number stands at a multiple of its own size, counted after those four; a text
has its length in front, with the NUL that ends it).

A fast path handles the usual case, and only notices unusual values. A careful path alone decides
what is wrong.
"""

import struct
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rosbase.messages import Header, Imu, MagneticField, Quaternion, Time, Vector3
from rosbase_ros2.kinds import as_float, as_floats, as_int, as_message, as_text

__all__ = ["ImuEncoder", "MagneticFieldEncoder", "sample_packer"]

_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_FRAMES_KEPT = 64
_NS_PER_S = 1_000_000_000
_UNUSUAL = (AttributeError, KeyError, TypeError, struct.error)
_all_floats = frozenset((float,)).issuperset

# Takes _LITTLE_ENDIAN, seconds, nanoseconds, the frame as it is sent, and the numbers.
_Layout: TypeAlias = tuple[Callable[..., bytes], bytes]
# The quantities of a message in their order, each a group of axes or a covariance (None).
_Parts: TypeAlias = tuple[tuple[str, type | None], ...]

_AXES = {Quaternion: "xyzw", Vector3: "xyz"}
_IMU: _Parts = (
    ("orientation", Quaternion),
    ("orientation_covariance", None),
    ("angular_velocity", Vector3),
    ("angular_velocity_covariance", None),
    ("linear_acceleration", Vector3),
    ("linear_acceleration_covariance", None),
)
_MAGNETIC_FIELD: _Parts = (("magnetic_field", Vector3), ("magnetic_field_covariance", None))


class ImuEncoder:
    """Encoder of sensor_msgs/Imu. Use it from any thread."""

    def __init__(self) -> None:
        self._layouts: dict[str, _Layout] = {}

    def encode(self, imu: Imu) -> bytes:
        """Return the bytes of the sample as `rclpy.serialization.serialize_message` does.

        Raises:
            TypeError: a field has a value of the wrong kind.
            ValueError: a value is out of the range of its field.
        """
        try:
            header, turned = imu.header, imu.orientation
            rate, force = imu.angular_velocity, imu.linear_acceleration
            sec, nanosec = header.stamp.sec, header.stamp.nanosec
            numbers = (
                *(turned.x, turned.y, turned.z, turned.w, *imu.orientation_covariance),
                *(rate.x, rate.y, rate.z, *imu.angular_velocity_covariance),
                *(force.x, force.y, force.z, *imu.linear_acceleration_covariance),
            )
            # struct would take a bool for a number.
            if _all_floats(map(type, numbers)) and type(sec) is int is type(nanosec):
                pack, frame = self._layouts[header.frame_id]
                return pack(_LITTLE_ENDIAN, sec, nanosec, frame, *numbers)
        except _UNUSUAL:
            pass
        return _encode_carefully(imu, Imu, _IMU, self._layouts)


class MagneticFieldEncoder:
    """Encoder of sensor_msgs/MagneticField. Use it from any thread."""

    def __init__(self) -> None:
        self._layouts: dict[str, _Layout] = {}

    def encode(self, sample: MagneticField) -> bytes:
        """Return the bytes of the sample; see `ImuEncoder.encode`."""
        try:
            header, field = sample.header, sample.magnetic_field
            sec, nanosec = header.stamp.sec, header.stamp.nanosec
            numbers = (field.x, field.y, field.z, *sample.magnetic_field_covariance)
            if _all_floats(map(type, numbers)) and type(sec) is int is type(nanosec):
                pack, frame = self._layouts[header.frame_id]
                return pack(_LITTLE_ENDIAN, sec, nanosec, frame, *numbers)
        except _UNUSUAL:
            pass
        return _encode_carefully(sample, MagneticField, _MAGNETIC_FIELD, self._layouts)


def sample_packer(template: Imu) -> Callable[..., bytes]:
    """Return a packer of samples that differ from the template only in stamp and numbers.

    It takes the arguments of `rosbase.ImuSender`, and checks nothing again either.

    Raises:
        TypeError: a field of the template has a value of the wrong kind.
        ValueError: a value is out of the range of its field.
    """
    ImuEncoder().encode(template)
    head = _LITTLE_ENDIAN
    frame = _frame(template.header.frame_id)
    pack_nine = struct.Struct("<9d").pack
    turned = pack_nine(*template.orientation_covariance)
    rate = pack_nine(*template.angular_velocity_covariance)
    force = pack_nine(*template.linear_acceleration_covariance)
    pack = struct.Struct(f"<4siI{len(frame)}s4d72s3d72s3d72s").pack

    def pack_sample(
        stamp_ns: int,
        orientation: Sequence[float],
        angular: Sequence[float],
        linear: Sequence[float],
    ) -> bytes:
        sec, nanosec = divmod(stamp_ns, _NS_PER_S)
        return pack(head, sec, nanosec, frame, *orientation, turned, *angular, rate, *linear, force)

    return pack_sample


def _encode_carefully(
    message: Any, kind: type, parts: _Parts, layouts: dict[str, _Layout]
) -> bytes:
    """Check each field separately, and keep the layout for the next sample with that frame."""
    where = kind.__name__
    header = as_message(as_message(message, where, kind).header, f"{where}.header", Header)
    stamp = as_message(header.stamp, f"{where}.header.stamp", Time)
    sec = as_int(stamp.sec, f"{where}.header.stamp.sec", -(2**31), 2**31 - 1)
    nanosec = as_int(stamp.nanosec, f"{where}.header.stamp.nanosec", 0, 2**32 - 1)
    frame_id = as_text(header.frame_id, f"{where}.header.frame_id")
    numbers = [
        number
        for name, part in parts
        for number in _part(getattr(message, name), f"{where}.{name}", part)
    ]
    # A program has a handful of frames; one that makes up names must not fill the memory.
    if len(layouts) >= _FRAMES_KEPT:
        layouts.clear()
    pack, frame = layouts[frame_id] = _layout(frame_id, len(numbers))
    return pack(_LITTLE_ENDIAN, sec, nanosec, frame, *numbers)


def _part(value: Any, where: str, kind: type | None) -> Sequence[float]:
    if kind:
        as_message(value, where, kind)
        return [as_float(getattr(value, axis), f"{where}.{axis}") for axis in _AXES[kind]]
    numbers = as_floats(value, where)
    if len(numbers) != 9:
        raise ValueError(f"{where} takes 9 elements, not {len(numbers)}")
    return numbers


def _layout(frame_id: str, count: int) -> _Layout:
    frame = _frame(frame_id)
    return struct.Struct(f"<4siI{len(frame)}s{count}d").pack, frame


def _frame(frame_id: str) -> bytes:
    text = frame_id.encode() + b"\0"
    frame = struct.pack("<I", len(text)) + text
    # The stamp before it takes 8 bytes, so the numbers begin at the next multiple of 8.
    return frame + bytes(-len(frame) % 8)
