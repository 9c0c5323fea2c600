"""How a class says which ROS message it is, and how wide its fields are.

A message is a frozen attrs class or a frozen dataclass with the decorator `message`. The
annotations of its fields name the ROS types. Without a width, `float` is float64, `str` is
string and `bool` is bool; a tuple is a sequence, and a message class is a nested message.
"""

from collections.abc import Callable
from enum import Enum
from typing import Annotated, Any, Protocol, TypeAlias, TypeVar

from attrs import Attribute, field

from rosbase.messages.buffers import numbers, protect_buffers
from rosbase.messages.constructor import put_into_slots, usual
from rosbase.messages.marks import AtMost, Fixed, Numbers
from rosbase.messages.widths import Width

__all__ = [
    "AtMost",
    "Buffer",
    "Byte",
    "Char",
    "Fixed",
    "Float32",
    "Float64",
    "Int8",
    "Int16",
    "Int32",
    "Int64",
    "Numbers",
    "UInt8",
    "UInt16",
    "UInt32",
    "UInt64",
    "WString",
    "Width",
    "fixed",
    "is_frozen",
    "message",
    "numbers",
    "ros_type",
    "sequence",
]

ClassT = TypeVar("ClassT", bound=type)

_ROS_TYPE = "__ros_type__"


class NumpyArray(Protocol):
    """The part of a numpy array that rosbase uses; numpy need not be installed."""

    @property
    def dtype(self) -> Any:
        """The type of its elements."""
        ...

    @property
    def flags(self) -> Any:
        """Whether it can be written to."""
        ...

    def tobytes(self) -> bytes:
        """Return a copy of its data."""
        ...


Buffer: TypeAlias = bytes | memoryview | NumpyArray | tuple[Any, ...]
"""Many numbers that nobody copies.

They are bytes, a read-only memoryview, a read-only numpy array, or, for few numbers, a tuple.
"""

# The one of every frozen class of attrs.
_REFUSE_TO_SET: object = AtMost.__setattr__

Byte: TypeAlias = Annotated[int, Width.BYTE]
Char: TypeAlias = Annotated[int, Width.CHAR]
Float32: TypeAlias = Annotated[float, Width.FLOAT32]
Float64: TypeAlias = Annotated[float, Width.FLOAT64]
Int8: TypeAlias = Annotated[int, Width.INT8]
Int16: TypeAlias = Annotated[int, Width.INT16]
Int32: TypeAlias = Annotated[int, Width.INT32]
Int64: TypeAlias = Annotated[int, Width.INT64]
UInt8: TypeAlias = Annotated[int, Width.UINT8]
UInt16: TypeAlias = Annotated[int, Width.UINT16]
UInt32: TypeAlias = Annotated[int, Width.UINT32]
UInt64: TypeAlias = Annotated[int, Width.UINT64]
WString: TypeAlias = Annotated[str, Width.WSTRING]


def message(name: str) -> Callable[[ClassT], ClassT]:
    """Return a decorator that declares a frozen class to be the ROS message of that name.

    Args:
        name: Its package, kind and name, such as `sensor_msgs/msg/Imu`.

    Raises:
        ValueError: The name has another form.
        TypeError: An instance of the class can be changed.
    """
    parts = str(name).split("/")
    package, kind, own = parts if len(parts) == 3 else ("", "", "")
    if not (package.isidentifier() and kind in ("msg", "srv", "action") and own.isidentifier()):
        raise ValueError(f"a message is named like sensor_msgs/msg/Imu, not {name!r}")

    def declare(cls: ClassT) -> ClassT:
        if not is_frozen(cls) or not _has_fields(cls):
            reason = "has no fields" if is_frozen(cls) else "can be changed after it was published"
            raise TypeError(
                f"{cls.__name__} {reason}; make it a frozen attrs class or a frozen dataclass,"
                " below this decorator"
            )
        setattr(cls, _ROS_TYPE, name)
        protect_buffers(cls)
        # The file that a message of ours is in is nobody's business.
        home, _, file = cls.__module__.rpartition(".")
        if home.startswith("rosbase.messages") and "__attrs_attrs__" in vars(cls):
            put_into_slots(cls)
        if home.startswith("rosbase.messages.") and file.startswith("_"):
            cls.__module__ = home
        return cls

    return declare


def ros_type(cls: Any) -> str | None:
    """Return the ROS name of a message class; None if it has none.

    A subclass has that of its base, unless it has fields of its own.
    """
    for one in cls.__mro__ if isinstance(cls, type) else ():
        own = vars(one)
        if _ROS_TYPE in own:
            name: str = own[_ROS_TYPE]
            return name
        if "__attrs_attrs__" in own or "__dataclass_fields__" in own:
            break
    return None


def is_frozen(cls: type) -> bool:
    """Return whether no attribute of an instance can be set: a frozen class, a tuple, a number."""
    own = vars(cls)
    if "__dataclass_params__" in own:
        return bool(own["__dataclass_params__"].frozen)
    if "__attrs_attrs__" in own:
        # A class that can be changed has a method of its own too if a field has a hook.
        setter: object = cls.__setattr__
        return setter is _REFUSE_TO_SET
    return issubclass(cls, (tuple, str, bytes, int, float, Enum))


def _has_fields(cls: type) -> bool:
    return "__attrs_attrs__" in vars(cls) or "__dataclass_fields__" in vars(cls)


def fixed(size: int, value: Any = 0.0, *, octets: bool = False) -> Any:
    """Return a field of exactly `size` elements, all `value` by default; see `sequence`."""

    @usual(tuple, size)
    def check(instance: Any, attribute: "Attribute[Any]", given: Any) -> None:
        if type(given) is not tuple:
            given = _keep_as_tuple(instance, attribute.name, given, octets=octets)
        if len(given) != size:
            raise ValueError(f"{attribute.name} takes {size} elements, not {len(given)}")

    return field(default=(value,) * size, validator=check)


def sequence(*, octets: bool = False) -> Any:
    """Return a field for a tuple, empty by default.

    A list or an array of one dimension becomes a tuple of Python's own numbers. Otherwise whoever
    has made the list could change the message, and messages could not be compared.

    Args:
        octets: Whether bytes become one, too.
    """

    @usual(tuple)
    def check(instance: Any, attribute: "Attribute[Any]", given: Any) -> None:
        if type(given) is not tuple:
            _keep_as_tuple(instance, attribute.name, given, octets=octets)

    return field(default=(), validator=check)


def _keep_as_tuple(instance: Any, name: str, given: Any, *, octets: bool) -> tuple[Any, ...]:
    """Set a field to the elements that it was given, and return them."""
    if isinstance(given, (list, tuple)) or (octets and isinstance(given, (bytes, bytearray))):
        elements = tuple(given)
    elif hasattr(given, "tolist") and getattr(given, "ndim", 1) == 1:
        elements = tuple(given.tolist())
    else:
        raise TypeError(
            f"{name} takes a tuple, a list or an array of one dimension, not {_kind(given)}"
        )
    # Not by a converter: attrs before 24.1 does not tell it the name of the field.
    object.__setattr__(instance, name, elements)
    return elements


def _kind(given: Any) -> str:
    count = getattr(given, "ndim", 1)
    return type(given).__name__ if count == 1 else f"one of {count} dimensions"
