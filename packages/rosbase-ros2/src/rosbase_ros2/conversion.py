"""Conversion of rosbase messages to ROS messages, and back.

A converter is made once for a type, from the fields of both sides. So for each message, the place
and the kind of every field are already known.
"""

import typing
from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeAlias

import attrs

from rosbase.messages.fields import ros_type
from rosbase_ros2.kinds import (
    LIST,
    TYPECODES,
    Check,
    Read,
    as_message,
    basic_kind,
    list_check,
    numbers_back,
)

__all__ = ["Accept", "Ask", "Conversions", "Converter"]

_OUR_OWN = "rosbase.messages."

Fill: TypeAlias = Callable[[Any, Any], None]
"""Function that copies a message of rosbase into a ROS message."""


@attrs.frozen
class Converter:
    """Conversion of one type of message to a ROS message, and back."""

    msg_type: type
    """Message class that programs publish and receive."""
    ros_type: type
    """ROS message class on the network."""
    to_ros: Callable[[Any], Any]
    """Returns a new ROS message. TypeError or ValueError names a field that cannot be converted."""
    from_ros: Callable[[Any], Any]
    """Returns the rosbase message for a ROS message."""


Accept: TypeAlias = Callable[[Any], Converter]
"""Function that takes a message class of ROS or a `Converter`.

TypeError says why it cannot be used.
"""
Ask: TypeAlias = Callable[[type, Accept], Converter | None]
"""Function that takes a class and an acceptor of answers.

It returns the acceptor's result, or None without an answer.
"""


class Conversions:
    """Converters, each made on first use.

    The package of its ROS message is imported only then.
    """

    def __init__(self, ask: Ask | None = None) -> None:
        """Take the function that is asked about a class of neither rosbase nor ROS."""
        self._ask = ask or _know_nothing
        self._given: dict[type, Converter | None] = {}
        self._made: dict[type, Converter] = {}

    def of(self, msg_type: type) -> Converter:
        """Return the converter of a message type, from any thread.

        A ROS message class is left as it is.

        Raises:
            TypeError: The type is unknown.
            PluginError: A plugin's conversion for it, or for a part of it, is unusable.
        """
        found = self._made.get(msg_type)
        if found is None:
            # Two threads may both make it; either will do.
            found = self._made[msg_type] = self._make(msg_type)
        return found

    def is_converted(self, msg_type: type) -> bool:
        """Return whether a plugin converts messages of this class.

        Raises:
            PluginError: A plugin's conversion for it is unusable.
        """
        return self._from_plugin(msg_type) is not None

    def derive(self, msg_type: type, ros_type: type) -> Converter:
        """Return a converter for an attrs class that has the fields of a ROS message class.

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
        found = self._from_plugin(msg_type)
        name = ros_type(msg_type)
        if found is None and name is not None:
            return self.derive(msg_type, _ros_class(name))
        if found is None:
            name = getattr(msg_type, "__qualname__", None) or repr(msg_type)
            raise TypeError(
                f"{name} is neither a message of rosbase nor of ROS, and no plugin has a conversion"
            )
        return found

    def _from_plugin(self, kind: Any) -> Converter | None:
        """Return a plugin's converter for a class; the plugin is asked once."""
        if not isinstance(kind, type) or kind.__module__.startswith(_OUR_OWN):
            return None
        if kind not in self._given:
            self._given[kind] = self._ask(kind, lambda given: self._accept(kind, given))
        return self._given[kind]

    def _accept(self, kind: type, given: Any) -> Converter:
        if isinstance(given, Converter) and given.msg_type is kind:
            return given
        if _is_ros(given):
            return self.derive(kind, given)
        raise TypeError(f"{given!r} is neither a ROS message class nor a Converter for this one")

    def _part(self, kind: Any, ros_kind: str, where: str) -> Converter | None:
        """Return a plugin's converter for the class of a field, where ROS has its own class."""
        given = self._from_plugin(kind)
        if given and given.ros_type is not _ros_class(ros_kind):
            raise TypeError(f"{where} is {ros_kind} in ROS, which is not what a {kind.__name__} is")
        return given

    def _fill(self, msg_type: type, ros_type: Any, where: str) -> Fill:
        """Return a function that fills an existing ROS message, so that none is built twice."""
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
        is_message = "/" in ros_kind and not LIST.fullmatch(ros_kind)
        if is_message and self._part(kind, ros_kind, where) is None:
            fill_in = self._fill(kind, _ros_class(ros_kind), where)

            def descend(message: Any, ros: Any) -> None:
                fill_in(getattr(message, name), getattr(ros, name))

            return descend
        check = self._check(kind, ros_kind, where)

        def put(message: Any, ros: Any) -> None:
            setattr(ros, name, check(getattr(message, name), where))

        return put

    def _check(self, kind: Any, ros_kind: str, where: str) -> Check:
        if found := LIST.fullmatch(ros_kind):
            element, size = found["array"] or found["sequence"], found["size"]
            each = self._check(_element(kind), element, where)
            return list_check(element, each, int(size) if size else None)
        if "/" not in ros_kind:
            return basic_kind(ros_kind, where)[0]
        given = self._part(kind, ros_kind, where)
        return _checked_by(given or self.derive(kind, _ros_class(ros_kind)))

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
        if found := LIST.fullmatch(ros_kind):
            element = found["array"] or found["sequence"]
            if element in TYPECODES:
                return numbers_back
            each = self._read(_element(kind), element, where)
            return lambda values: tuple(map(each, values))
        if "/" not in ros_kind:
            return basic_kind(ros_kind, where)[1]
        if given := self._part(kind, ros_kind, where):
            return given.from_ros
        return self._reader(kind, _ros_class(ros_kind))


def _know_nothing(kind: type, accept: Accept) -> None:
    """Return None: no plugin is asked."""


def _checked_by(converter: Converter) -> Check:
    kind, convert = converter.msg_type, converter.to_ros

    def check(value: Any, where: str) -> Any:
        return convert(as_message(value, where, kind))

    return check


def _same(value: Any) -> Any:
    return value


def _fields(msg_type: type, ros_type: Any) -> list[tuple[str, Any, str]]:
    """Return name, type and ROS type of each field."""
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
    """Return the type of the elements of a tuple type."""
    return (typing.get_args(kind) or (object,))[0]


def _is_ros(kind: Any) -> bool:
    return hasattr(kind, "get_fields_and_field_types") and hasattr(kind, "_TYPE_SUPPORT")


def _ros_class(name: str) -> type:
    package, *_, kind = name.split("/")
    found: type = getattr(import_module(f"{package}.msg"), kind)
    return found
