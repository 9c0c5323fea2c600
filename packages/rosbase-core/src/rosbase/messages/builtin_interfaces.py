"""Time and duration, as the ROS package builtin_interfaces has them; both can be computed with."""

import sys
from operator import index
from typing import Any, overload

from attrs import Attribute, field, frozen

from rosbase.messages import fields as ros
from rosbase.messages.constructor import usual
from rosbase.messages.fields import message

__all__ = ["STAMPS_END_NS", "Duration", "Time", "duration_field", "is_stamp", "time_field"]

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


def _nanoseconds_of(value: Any, name: str) -> int | None:
    """Return the nanoseconds of a time or a duration, rclpy's too; None if it is no such thing."""
    if type(value).__name__ != name:
        return None
    try:
        if hasattr(value, "nanoseconds"):
            return index(value.nanoseconds)
        return index(value.sec) * _NS_PER_S + index(value.nanosec)
    except (AttributeError, TypeError):
        return None


def _for_ros(value: Any, name: str) -> Any:
    """Return a time or a duration as ROS messages take it, where the program has loaded those."""
    found = getattr(sys.modules.get("builtin_interfaces.msg"), name, None)
    return value if found is None else found(sec=index(value.sec), nanosec=index(value.nanosec))


def _field_of(kind: Any) -> Any:
    """Return a field that takes the time or duration of rosbase, ROS or rclpy, and has ours."""
    name = kind.__name__

    @usual(kind)
    def check(instance: Any, attribute: "Attribute[Any]", given: Any) -> None:
        if not isinstance(given, kind):
            nanoseconds = _nanoseconds_of(given, name)
            if nanoseconds is not None:
                # Whoever has made it could change it.
                object.__setattr__(instance, attribute.name, kind.from_nanoseconds(nanoseconds))

    return field(default=kind(), validator=check)


@message("builtin_interfaces/msg/Duration")
@frozen(eq=False)
class Duration:
    """Length of time, which may be negative, as builtin_interfaces/Duration has it."""

    sec: ros.Int32 = 0
    """Whole seconds, rounded down."""
    nanosec: ros.UInt32 = 0
    """Nanoseconds to be added, 0 to 999,999,999."""

    @classmethod
    def from_nanoseconds(cls, nanoseconds: int) -> "Duration":
        """Return the duration of that many nanoseconds."""
        return cls(*divmod(nanoseconds, _NS_PER_S))

    @property
    def nanoseconds(self) -> int:
        """Length in nanoseconds."""
        # The 32-bit numbers of numpy would overflow.
        return index(self.sec) * _NS_PER_S + index(self.nanosec)

    def to_msg(self) -> Any:
        """Return it as a field of a ROS message takes it, and a field of rosbase's messages too.

        In a program that has loaded no messages of ROS, that is the object itself.
        """
        return _for_ros(self, "Duration")

    @overload
    def __add__(self, other: "Duration") -> "Duration": ...
    @overload
    def __add__(self, other: "Time") -> "Time": ...
    @overload
    def __add__(self, other: Any) -> Any: ...
    def __add__(self, other: Any) -> Any:
        """Return the sum of two durations, or the time that much after another."""
        when, length = _nanoseconds_of(other, "Time"), _nanoseconds_of(other, "Duration")
        if when is not None:
            return Time.from_nanoseconds(when + self.nanoseconds)
        if length is None:
            return NotImplemented
        return Duration.from_nanoseconds(self.nanoseconds + length)

    def __radd__(self, other: Any) -> Any:
        """Return the same as in the other order: rclpy's objects know only rclpy's."""
        return self.__add__(other)

    def __rsub__(self, other: Any) -> Any:
        """Return the time that much before a time of rclpy, or what is left of a duration."""
        when, length = _nanoseconds_of(other, "Time"), _nanoseconds_of(other, "Duration")
        if when is not None:
            return Time.from_nanoseconds(when - self.nanoseconds)
        if length is None:
            return NotImplemented
        return Duration.from_nanoseconds(length - self.nanoseconds)

    def __sub__(self, other: "Duration") -> "Duration":
        length = _nanoseconds_of(other, "Duration")
        if length is None:
            return NotImplemented
        return Duration.from_nanoseconds(self.nanoseconds - length)

    def __eq__(self, other: object) -> bool:
        length = _nanoseconds_of(other, "Duration")
        return NotImplemented if length is None else self.nanoseconds == length

    def __hash__(self) -> int:
        return hash(self.nanoseconds)

    def __neg__(self) -> "Duration":
        return Duration.from_nanoseconds(-self.nanoseconds)

    def __lt__(self, other: "Duration") -> bool:
        length = _nanoseconds_of(other, "Duration")
        return NotImplemented if length is None else self.nanoseconds < length

    def __le__(self, other: "Duration") -> bool:
        length = _nanoseconds_of(other, "Duration")
        return NotImplemented if length is None else self.nanoseconds <= length

    def __gt__(self, other: "Duration") -> bool:
        length = _nanoseconds_of(other, "Duration")
        return NotImplemented if length is None else self.nanoseconds > length

    def __ge__(self, other: "Duration") -> bool:
        length = _nanoseconds_of(other, "Duration")
        return NotImplemented if length is None else self.nanoseconds >= length


@message("builtin_interfaces/msg/Time")
@frozen(eq=False)
class Time:
    """Point in time since the Unix epoch, as builtin_interfaces/Time has it."""

    sec: ros.Int32 = 0
    """Whole seconds."""
    nanosec: ros.UInt32 = 0
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
        # The 32-bit numbers of numpy would overflow.
        return index(self.sec) * _NS_PER_S + index(self.nanosec)

    def to_msg(self) -> Any:
        """Return it as a field of a ROS message takes it, and a field of rosbase's messages too.

        In a program that has loaded no messages of ROS, that is the object itself.
        """
        return _for_ros(self, "Time")

    def __add__(self, other: Duration) -> "Time":
        length = _nanoseconds_of(other, "Duration")
        if length is None:
            return NotImplemented
        return Time.from_nanoseconds(self.nanoseconds + length)

    __radd__ = __add__

    @overload
    def __sub__(self, other: "Time") -> Duration: ...
    @overload
    def __sub__(self, other: Duration) -> "Time": ...
    @overload
    def __sub__(self, other: Any) -> Any: ...
    def __sub__(self, other: Any) -> Any:
        """Return the duration since another time, or the time before a duration."""
        since = _nanoseconds_of(other, "Time")
        if since is not None:
            return Duration.from_nanoseconds(self.nanoseconds - since)
        length = _nanoseconds_of(other, "Duration")
        if length is None:
            return NotImplemented
        return Time.from_nanoseconds(self.nanoseconds - length)

    def __rsub__(self, other: Any) -> Any:
        """Return the duration from this time to one of rclpy's."""
        when = _nanoseconds_of(other, "Time")
        if when is None:
            return NotImplemented
        return Duration.from_nanoseconds(when - self.nanoseconds)

    def __eq__(self, other: object) -> bool:
        when = _nanoseconds_of(other, "Time")
        return NotImplemented if when is None else self.nanoseconds == when

    def __hash__(self) -> int:
        return hash(self.nanoseconds)

    def __lt__(self, other: "Time") -> bool:
        when = _nanoseconds_of(other, "Time")
        return NotImplemented if when is None else self.nanoseconds < when

    def __le__(self, other: "Time") -> bool:
        when = _nanoseconds_of(other, "Time")
        return NotImplemented if when is None else self.nanoseconds <= when

    def __gt__(self, other: "Time") -> bool:
        when = _nanoseconds_of(other, "Time")
        return NotImplemented if when is None else self.nanoseconds > when

    def __ge__(self, other: "Time") -> bool:
        when = _nanoseconds_of(other, "Time")
        return NotImplemented if when is None else self.nanoseconds >= when


def time_field() -> Any:
    """Return a field for a time, zero by default. That of a ROS message becomes one of rosbase."""
    return _field_of(Time)


def duration_field() -> Any:
    """Return a field for a duration, zero by default. That of ROS becomes one of rosbase."""
    return _field_of(Duration)
