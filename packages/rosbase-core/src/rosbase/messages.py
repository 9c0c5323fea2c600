"""Messages, with the names, units and conventions of ROS 2, and without ROS.

Messages are immutable: every subscriber gets the same object, on any thread, without a copy. To
change one, use `attrs.evolve(message, ...)`.

Sources: common_interfaces (`sensor_msgs`, `geometry_msgs`, `std_msgs`, `diagnostic_msgs`),
REP-103 (units), REP-145 (IMU drivers).
"""

from typing import ClassVar, TypeAlias

from attrs import Attribute, field, frozen

__all__ = [
    "COVARIANCE_NOT_REPORTED",
    "COVARIANCE_UNKNOWN",
    "STAMPS_END_NS",
    "Bool",
    "Covariance",
    "DiagnosticArray",
    "DiagnosticStatus",
    "Header",
    "Imu",
    "JointState",
    "Joy",
    "KeyValue",
    "MagneticField",
    "Point",
    "PointStamped",
    "Pose",
    "PoseStamped",
    "Quaternion",
    "String",
    "Time",
    "Twist",
    "Vector3",
    "is_stamp",
]

Covariance: TypeAlias = tuple[float, float, float, float, float, float, float, float, float]
"""A 3 x 3 matrix, row-major about x, y, z, in the squared unit of its quantity."""

COVARIANCE_UNKNOWN: Covariance = (0.0,) * 9
"""Covariance of a quantity whose accuracy is not known (sensor_msgs/Imu)."""

COVARIANCE_NOT_REPORTED: Covariance = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""Covariance of a quantity that is not measured; its values mean nothing (sensor_msgs/Imu)."""

_NS_PER_S = 1_000_000_000

STAMPS_END_NS = 2**31 * _NS_PER_S
"""End of ROS stamps, in nanoseconds since the Unix epoch: 2038-01-19 03:14:08 UTC.

The seconds of builtin_interfaces/Time are an int32.
"""


def is_stamp(nanoseconds: int) -> bool:
    """Return whether a ROS stamp can carry a time, in nanoseconds since the Unix epoch.

    rcl and DDS take no time before 1970, although an int32 has room for it, and zero means that
    there is no time yet.
    """
    return 0 < nanoseconds < STAMPS_END_NS


def _nine(instance: object, attribute: "Attribute[Covariance]", value: Covariance) -> None:
    if len(value) != 9:
        raise ValueError(f"{attribute.name} takes 9 numbers, row by row, not {len(value)}")


@frozen
class Time:
    """A point in time since the Unix epoch, as builtin_interfaces/Time has it."""

    sec: int = 0
    """Whole seconds."""
    nanosec: int = 0
    """Nanoseconds within the second, 0 to 999,999,999."""

    @classmethod
    def from_nanoseconds(cls, nanoseconds: int) -> "Time":
        """Return the time that many nanoseconds after the epoch."""
        return cls(*divmod(nanoseconds, _NS_PER_S))

    @classmethod
    def as_stamp(cls, nanoseconds: int) -> "Time":
        """Return that time as a stamp: zero if ROS cannot carry it (see `is_stamp`)."""
        return cls(*divmod(nanoseconds, _NS_PER_S)) if is_stamp(nanoseconds) else cls()

    @property
    def nanoseconds(self) -> int:
        """Nanoseconds since the epoch."""
        return self.sec * _NS_PER_S + self.nanosec

    def to_msg(self) -> "Time":
        """Return the object itself: programs for rclpy's clock call this method."""
        return self


@frozen
class Header:
    """Time and frame of a measurement (std_msgs/Header)."""

    stamp: Time = Time()
    """Time of measurement."""
    frame_id: str = ""
    """Name of the sensor's frame."""


@frozen
class Bool:
    """Yes or no (std_msgs/Bool)."""

    data: bool = False


@frozen
class String:
    """Text (std_msgs/String)."""

    data: str = ""


@frozen
class Vector3:
    """Three components along the axes of a right-handed frame (geometry_msgs/Vector3)."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@frozen
class Quaternion:
    """A rotation; the default is none (geometry_msgs/Quaternion)."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


@frozen
class Point:
    """Position in a frame, in metres (geometry_msgs/Point)."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@frozen
class PointStamped:
    """Position with its time and frame (geometry_msgs/PointStamped)."""

    header: Header = Header()
    point: Point = Point()


@frozen
class Pose:
    """Position and orientation (geometry_msgs/Pose)."""

    position: Point = Point()
    """Position in metres."""
    orientation: Quaternion = Quaternion()
    """Orientation, a unit quaternion."""


@frozen
class PoseStamped:
    """Pose with its time and frame (geometry_msgs/PoseStamped)."""

    header: Header = Header()
    pose: Pose = Pose()


@frozen
class Twist:
    """Velocity, measured or commanded (geometry_msgs/Twist)."""

    linear: Vector3 = Vector3()
    """Linear velocity in m/s; forward, left and up for a robot."""
    angular: Vector3 = Vector3()
    """Angular velocity in rad/s about the same axes; positive z turns left."""


@frozen
class Joy:
    """Axes and buttons of a joystick (sensor_msgs/Joy)."""

    header: Header = Header()
    axes: tuple[float, ...] = ()
    """Positions of the axes, -1 to 1 each; left and forward are positive."""
    buttons: tuple[int, ...] = ()
    """State of each button: 1 while it is pressed, else 0."""


@frozen
class JointState:
    """Joints of a robot (sensor_msgs/JointState).

    Each tuple has one element per name, or is empty if the quantity is not known.
    """

    header: Header = Header()
    name: tuple[str, ...] = ()
    position: tuple[float, ...] = ()
    """Positions in rad, or m for a sliding joint."""
    velocity: tuple[float, ...] = ()
    """Velocities in rad/s, or m/s."""
    effort: tuple[float, ...] = ()
    """Efforts in Nm, or N."""


@frozen
class Imu:
    """One sample of an inertial measurement unit (sensor_msgs/Imu).

    A quantity that the device does not report has -1 as the first element of its
    covariance.
    """

    header: Header = Header()
    orientation: Quaternion = Quaternion()
    """Orientation of the sensor frame in the world frame (ENU), a unit quaternion."""
    orientation_covariance: Covariance = field(default=COVARIANCE_UNKNOWN, validator=_nine)
    """Covariance in rad^2, about x, y, z."""
    angular_velocity: Vector3 = Vector3()
    """Angular velocity in rad/s, in the sensor frame."""
    angular_velocity_covariance: Covariance = field(default=COVARIANCE_UNKNOWN, validator=_nine)
    """Covariance in (rad/s)^2."""
    linear_acceleration: Vector3 = Vector3()
    """Specific force in m/s^2: a sensor that lies flat and still shows +9.81 on z."""
    linear_acceleration_covariance: Covariance = field(default=COVARIANCE_UNKNOWN, validator=_nine)
    """Covariance in (m/s^2)^2."""


@frozen
class MagneticField:
    """One sample of a magnetometer (sensor_msgs/MagneticField)."""

    header: Header = Header()
    magnetic_field: Vector3 = Vector3()
    """Magnetic field in tesla, in the sensor frame; NaN on an axis that is not reported."""
    magnetic_field_covariance: Covariance = field(default=COVARIANCE_UNKNOWN, validator=_nine)
    """Covariance in T^2; all zeros: unknown."""


@frozen
class KeyValue:
    """Name and value of a detail (diagnostic_msgs/KeyValue)."""

    key: str = ""
    value: str = ""


@frozen
class DiagnosticStatus:
    """Status of one part of the robot (diagnostic_msgs/DiagnosticStatus)."""

    OK: ClassVar[int] = 0
    WARN: ClassVar[int] = 1
    ERROR: ClassVar[int] = 2
    STALE: ClassVar[int] = 3
    """No news of it for too long."""

    level: int = OK
    """One of the levels above; ROS has it as a byte."""
    name: str = ""
    """Name of the part."""
    message: str = ""
    """Description for a person."""
    hardware_id: str = ""
    """Identity of the device, such as a serial number."""
    values: tuple[KeyValue, ...] = ()
    """Further details."""


@frozen
class DiagnosticArray:
    """Status of several parts of the robot (diagnostic_msgs/DiagnosticArray)."""

    header: Header = Header()
    """Time of the status; the frame is not used."""
    status: tuple[DiagnosticStatus, ...] = ()
