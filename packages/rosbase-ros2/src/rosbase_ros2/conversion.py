"""Messages of rosbase to those of ROS, and back.

Nothing but the right kind of value gets into a ROS message. rclpy itself checks that only
where `ROS_PYTHON_CHECK_FIELDS` is 1; elsewhere it sends an int in a float field, a bool or
None as garbage, and a text only up to its first NUL, without a word.

A converter is made once for a type, out of the fields of both sides. What then runs for
each message knows already where a field goes and which kind it must be.
"""

import re
import typing
from array import array
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from numbers import Integral, Real
from typing import Any, TypeAlias

import attrs

from rosbase import messages

__all__ = [
    "Conversions",
    "Converter",
    "as_float",
    "as_floats",
    "as_int",
    "as_message",
    "as_text",
]

Check: TypeAlias = Callable[[Any, str], Any]
"""Takes a value and the name of its field; gives what goes into the ROS message."""
Fill: TypeAlias = Callable[[Any, Any], None]
"""Puts what a message of rosbase has into a ROS message."""
Read: TypeAlias = Callable[[Any], Any]
"""Gives what rosbase has for the value of a ROS field."""

_FLOAT32_MAX = 3.4028234663852886e38
_all_floats = frozenset((float,)).issuperset

_PACKAGES = {
    "builtin_interfaces": (messages.Time,),
    "diagnostic_msgs": (
        messages.DiagnosticArray,
        messages.DiagnosticStatus,
        messages.KeyValue,
    ),
    "geometry_msgs": (
        messages.Point,
        messages.PointStamped,
        messages.Pose,
        messages.PoseStamped,
        messages.Quaternion,
        messages.Twist,
        messages.Vector3,
    ),
    "sensor_msgs": (messages.Imu, messages.JointState, messages.Joy, messages.MagneticField),
    "std_msgs": (messages.Bool, messages.Header, messages.String),
}
_KNOWN: dict[type, str] = {kind: package for package, all_ in _PACKAGES.items() for kind in all_}


@attrs.frozen
class Converter:
    """How one type of message becomes a ROS message, and how that becomes one again."""

    msg_type: type
    """What programs publish and receive."""
    ros_type: type
    """What goes over the network."""
    to_ros: Callable[[Any], Any]
    """A new ROS message. TypeError or ValueError names the field that cannot go into one."""
    from_ros: Callable[[Any], Any]
    """The message that a ROS message amounts to."""


class Conversions:
    """The converters, each made when it is first needed.

    Only then is the package of its ROS message imported.
    """

    def __init__(self) -> None:
        self._registered: dict[type, Converter] = {}
        self._made: dict[type, Converter] = {}

    def register(self, converter: Converter) -> None:
        """From now on messages of its type are converted with it, inside others as well."""
        self._registered[converter.msg_type] = converter
        self._made = {}

    def of(self, msg_type: type) -> Converter:
        """The converter of a message type, from any thread.

        A ROS message class is left as it is.

        Raises:
            TypeError: nothing is known of that type.
        """
        found = self._registered.get(msg_type) or self._made.get(msg_type)
        if found is None:
            # Two threads may both make it; either will do.
            found = self._made[msg_type] = self._make(msg_type)
        return found

    def derive(self, msg_type: type, ros_type: type) -> Converter:
        """A converter for an attrs class that has the fields of a ROS message class.

        For your own messages: `conversions.register(conversions.derive(Mine, Theirs))`.

        Raises:
            TypeError: their fields are not the same, or cannot be converted like this.
        """
        fill = self._fill(msg_type, ros_type, msg_type.__name__)

        def to_ros(message: Any) -> Any:
            ros = ros_type()
            fill(message, ros)
            return ros

        return Converter(msg_type, ros_type, to_ros, self._reader(msg_type, ros_type))

    def _make(self, msg_type: type) -> Converter:
        if _is_ros(msg_type):
            return Converter(msg_type, msg_type, _same, _same)
        if msg_type not in _KNOWN:
            name = getattr(msg_type, "__qualname__", None) or repr(msg_type)
            raise TypeError(
                f"{name} is neither a message of rosbase nor of ROS;"
                " Conversions.register() takes a Converter for it"
            )
        return self.derive(msg_type, _ros_class(f"{_KNOWN[msg_type]}/{msg_type.__name__}"))

    def _fill(self, msg_type: type, ros_type: Any, where: str) -> Fill:
        """What fills in a ROS message that is there, so that none is built twice."""
        steps = tuple(
            self._step(name, kind, ros_kind, f"{where}.{name}")
            for name, kind, ros_kind in _fields(msg_type, ros_type)
        )

        def fill(message: Any, ros: Any) -> None:
            as_message(message, where, msg_type)
            for step in steps:
                step(message, ros)

        return fill

    def _step(self, name: str, kind: Any, ros_kind: str, where: str) -> Fill:
        if "/" in ros_kind and not _LIST.fullmatch(ros_kind) and kind not in self._registered:
            fill_in = self._fill(kind, _ros_class(ros_kind), where)

            def descend(message: Any, ros: Any) -> None:
                fill_in(getattr(message, name), getattr(ros, name))

            return descend
        check = self._check(kind, ros_kind, where)

        def put(message: Any, ros: Any) -> None:
            setattr(ros, name, check(getattr(message, name), where))

        return put

    def _check(self, kind: Any, ros_kind: str, where: str) -> Check:
        if found := _LIST.fullmatch(ros_kind):
            element, size = found["array"] or found["sequence"], found["size"]
            each = self._check(_element(kind), element, where)
            return _list_check(element, each, int(size) if size else None)
        if "/" not in ros_kind:
            return _basic(ros_kind, where)[0]
        if kind in self._registered:
            return _checked_by(self._registered[kind])
        return _checked_by(self.derive(kind, _ros_class(ros_kind)))

    def _reader(self, msg_type: type, ros_type: Any) -> Read:
        aliases = {field.name: field.alias for field in attrs.fields(msg_type)}
        reads = tuple(
            (aliases[name], name, self._read(kind, ros_kind, f"{msg_type.__name__}.{name}"))
            for name, kind, ros_kind in _fields(msg_type, ros_type)
        )

        def from_ros(ros: Any) -> Any:
            return msg_type(**{alias: read(getattr(ros, name)) for alias, name, read in reads})

        return from_ros

    def _read(self, kind: Any, ros_kind: str, where: str) -> Read:
        if found := _LIST.fullmatch(ros_kind):
            element = found["array"] or found["sequence"]
            if element in _TYPECODES:
                return _numbers_back
            each = self._read(_element(kind), element, where)
            return lambda values: tuple(map(each, values))
        if "/" not in ros_kind:
            return _basic(ros_kind, where)[1]
        if kind in self._registered:
            return self._registered[kind].from_ros
        return self._reader(kind, _ros_class(ros_kind))


def as_float(value: Any, where: str) -> float:
    """The number as a float, NaN included.

    Raises:
        TypeError: it is none; a bool and a text are none.
        ValueError: it is too large.
    """
    if type(value) is float:
        return value
    # numpy's scalars are numbers here, and a bool would be one too.
    if not isinstance(value, Real) or isinstance(value, bool):
        raise _wrong(value, where, "numbers")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{where} takes numbers that a float can hold") from None


def as_floats(value: Any, where: str) -> Sequence[float]:
    """The numbers of a list, a tuple or an array as floats; as in `as_float`."""
    values = _as_list(value, where)
    return values if _all_floats(map(type, values)) else [as_float(one, where) for one in values]


def as_int(value: Any, where: str, low: int, high: int) -> int:
    """The whole number.

    Raises:
        TypeError: it is none.
        ValueError: it is not within the two.
    """
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise _wrong(value, where, "whole numbers")
    number = int(value)
    if not low <= number <= high:
        raise ValueError(f"{where} takes whole numbers from {low} to {high}")
    return number


def as_message(value: Any, where: str, kind: type) -> Any:
    """The message.

    Raises:
        TypeError: it is of another type.
    """
    if not isinstance(value, kind):
        raise _wrong(value, where, f"messages of type {kind.__name__}")
    return value


def as_text(value: Any, where: str) -> str:
    """The text.

    Raises:
        TypeError: it is none.
        ValueError: it has a character that ROS cannot send: NUL, or half a surrogate pair.
    """
    if not isinstance(value, str):
        raise _wrong(value, where, "text")
    if "\0" in value or not (value.isascii() or _encodable(value)):
        raise ValueError(f"{where} takes text without NUL and without lone surrogates")
    return value


def _encodable(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _as_float32(value: Any, where: str) -> float:
    number = as_float(value, where)
    # What is infinite or NaN may stay so; only what would silently become infinite may not.
    if _FLOAT32_MAX < abs(number) < float("inf"):
        raise ValueError(f"{where} takes numbers that a 32-bit float can hold")
    return number


def _as_bool(value: Any, where: str) -> bool:
    if not isinstance(value, bool):
        raise _wrong(value, where, "True or False")
    return value


def _as_octet(value: Any, where: str) -> bytes:
    return bytes((as_int(value, where, 0, 255),))


def _as_list(value: Any, where: str) -> Sequence[Any]:
    if isinstance(value, list | tuple):
        return value
    # numpy's arrays and those of the standard library; a text is no list of texts.
    if isinstance(value, Iterable) and hasattr(value, "tolist"):
        return list(value.tolist())
    raise _wrong(value, where, "a tuple")


def _int_check(bits: int, *, signed: bool) -> Check:
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)

    def check(value: Any, where: str) -> int:
        # The usual case without a second call.
        if type(value) is int and low <= value <= high:
            return value
        return as_int(value, where, low, high)

    return check


def _list_check(element: str, each: Check, size: int | None) -> Check:
    typecode = _TYPECODES.get(element)
    whole = as_floats if typecode == "d" else None

    def check(value: Any, where: str) -> Any:
        if whole:
            values: Any = whole(value, where)
        else:
            values = [each(one, where) for one in _as_list(value, where)]
        if size is not None and len(values) != size:
            raise ValueError(f"{where} takes {size} elements, not {len(values)}")
        # The setter takes an array as it is; it would look at each element of a list.
        return values if size is not None or not typecode else array(typecode, values)

    return check


def _checked_by(converter: Converter) -> Check:
    kind, convert = converter.msg_type, converter.to_ros

    def check(value: Any, where: str) -> Any:
        return convert(as_message(value, where, kind))

    return check


def _wrong(value: object, where: str, wanted: str) -> TypeError:
    found = "None" if value is None else type(value).__name__
    return TypeError(f"{where} takes {wanted}, not {found}")


def _same(value: Any) -> Any:
    return value


def _numbers_back(values: Any) -> tuple[Any, ...]:
    return tuple(values.tolist())


# A sequence without a limit, or an array of a fixed size.
_LIST = re.compile(r"sequence<(?P<sequence>[\w/]+)>|(?P<array>[\w/]+)\[(?P<size>\d+)\]")

# What ROS keeps in an array of numbers, and Python's typecode for it.
_TYPECODES = {
    "double": "d",
    "float": "f",
    **{f"int{bits}": code for bits, code in ((8, "b"), (16, "h"), (32, "i"), (64, "q"))},
    **{f"uint{bits}": code for bits, code in ((8, "B"), (16, "H"), (32, "I"), (64, "Q"))},
}

_BASIC: dict[str, tuple[Check, Read]] = {
    "boolean": (_as_bool, bool),
    "double": (as_float, float),
    "float": (_as_float32, float),
    "octet": (_as_octet, lambda value: value[0]),
    "string": (as_text, str),
    **{f"int{bits}": (_int_check(bits, signed=True), int) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (_int_check(bits, signed=False), int) for bits in (8, 16, 32, 64)},
}


def _basic(ros_kind: str, where: str) -> tuple[Check, Read]:
    if ros_kind not in _BASIC:
        raise TypeError(f"{where} is of type {ros_kind} in ROS: it takes a Converter by hand")
    return _BASIC[ros_kind]


def _fields(msg_type: type, ros_type: Any) -> list[tuple[str, Any, str]]:
    """Name, type and ROS type of each field."""
    if not attrs.has(msg_type):
        raise TypeError(f"{msg_type} is no attrs class: it takes a Converter by hand")
    ros_kinds: dict[str, str] = ros_type.get_fields_and_field_types()
    names = {field.name for field in attrs.fields(msg_type)}
    if odd := sorted(names ^ ros_kinds.keys()):
        both = f"{msg_type.__name__} and {ros_type.__name__}"
        raise TypeError(f"{both} of ROS differ in fields: {', '.join(odd)}")
    kinds = typing.get_type_hints(msg_type)
    return [(name, kinds[name], ros_kind) for name, ros_kind in ros_kinds.items()]


def _element(kind: Any) -> Any:
    """What a tuple type consists of."""
    return (typing.get_args(kind) or (object,))[0]


def _is_ros(kind: Any) -> bool:
    return hasattr(kind, "get_fields_and_field_types") and hasattr(kind, "_TYPE_SUPPORT")


def _ros_class(name: str) -> type:
    package, kind = name.split("/")
    found: type = getattr(import_module(f"{package}.msg"), kind)
    return found
