"""How a class says which ROS message it is, and how wide its fields are.

A message is a frozen attrs class or a frozen dataclass with the decorator `message`. The
annotations of its fields name the ROS types. Without a width, `float` is float64, `str` is
string and `bool` is bool; a tuple is a sequence, and a message class is a nested message.
"""

from array import array
from collections.abc import Callable
from enum import Enum
from typing import Annotated, Any, Protocol, TypeAlias, TypeVar

from attrs import Attribute, field, frozen

from rosbase.messages.pickling import make_picklable
from rosbase.messages.widths import TYPECODES, Width

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
]

ClassT = TypeVar("ClassT", bound=type)

_ROS_TYPE = "__ros_type__"


_SAME_SIZE = {"q": "lq", "Q": "LQ", "i": "il", "I": "IL"}


@frozen
class Fixed:
    """An array of that many elements; in the annotation of a tuple or a buffer."""

    size: int


@frozen
class AtMost:
    """A sequence or a text of at most that many elements or bytes."""

    size: int


@frozen
class Numbers:
    """A buffer of numbers of that width."""

    width: Width


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
    package, _, rest = name.partition("/")
    kind, _, own = rest.partition("/")
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
        if _may_have_buffers(cls):
            make_picklable(cls)
        # The file that a message of ours is in is nobody's business.
        home, _, file = cls.__module__.rpartition(".")
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
    options = getattr(cls, "__dataclass_params__", None)
    if options is not None:
        return bool(options.frozen)
    setter: Any = cls.__setattr__
    if "__attrs_attrs__" in vars(cls):
        return setter is not object.__setattr__
    return issubclass(cls, (tuple, str, bytes, int, float, Enum))


def _has_fields(cls: type) -> bool:
    return "__attrs_attrs__" in vars(cls) or "__dataclass_fields__" in vars(cls)


def _may_have_buffers(cls: Any) -> bool:
    """Return whether a field is a buffer, or is declared by a text that may say so."""
    own = vars(cls)
    declared = own.get("__attrs_attrs__") or own.get("__dataclass_fields__", {}).values()
    hints = [one.type for one in declared]
    return any(
        isinstance(hint, str)
        or any(isinstance(mark, Numbers) for mark in getattr(hint, "__metadata__", ()))
        for hint in hints
    )


def fixed(size: int, value: Any = 0.0) -> Any:
    """Return a field of exactly `size` elements, all `value` by default."""

    def check(instance: object, attribute: "Attribute[Any]", given: Any) -> None:
        if len(given) != size:
            raise ValueError(f"{attribute.name} takes {size} elements, not {len(given)}")

    return field(default=(value,) * size, validator=check)


def numbers(width: Width, size: int | None = None) -> Any:
    """Return a field for a buffer of numbers of that width: any number of them, or `size`.

    A buffer that can be changed is refused, because a subscriber gets the same one. Two buffers
    are equal if their bytes are, whatever object holds them.
    """
    typecode = TYPECODES[width]
    allowed = _SAME_SIZE.get(typecode, typecode)

    def check(instance: object, attribute: "Attribute[Any]", given: Any) -> None:
        reason = _fault(given, allowed)
        if not reason and size is not None and _count(given) != size:
            reason = f"takes {size} elements, not {_count(given)}"
        if reason:
            raise (ValueError if "elements" in reason else TypeError)(f"{attribute.name} {reason}")

    def plain(value: Any) -> Any:
        try:
            return memoryview(
                array(typecode, value) if isinstance(value, tuple) else value
            ).tobytes()
        except (TypeError, ValueError, OverflowError):
            # It holds something else, and is only equal to the same.
            return value

    empty: Any = b"" if typecode == "B" else ()
    default = empty if size is None else (0,) * size
    return field(default=default, validator=check, eq=plain, repr=_shown)


def _fault(value: Any, allowed: str) -> str:
    """Return why a value cannot be a buffer of numbers; empty if it can."""
    if isinstance(value, (tuple, bytes)):
        is_wrong = isinstance(value, bytes) and "B" not in allowed
        return "takes numbers of another width than bytes have" if is_wrong else ""
    try:
        view = memoryview(value)
    except TypeError:
        return f"takes a tuple or a read-only buffer, not {type(value).__name__}"
    if not view.readonly:
        return (
            "takes a buffer that nobody can change: use bytes(...), memoryview(...).toreadonly(),"
            " or array.setflags(write=False) of numpy"
        )
    if not view.c_contiguous:
        return "takes a contiguous buffer: use numpy.ascontiguousarray(...)"
    if view.format.lstrip("<=@") not in allowed:
        return f"takes numbers of the format {allowed[-1]!r}, not {view.format!r}"
    return ""


def _count(value: Any) -> int:
    if isinstance(value, (tuple, bytes)):
        return len(value)
    # The length of an array of several dimensions is that of the first.
    view = memoryview(value)
    return view.nbytes // view.itemsize


def _shown(value: Any) -> str:
    most = 16 if isinstance(value, tuple) else 64
    if isinstance(value, (tuple, bytes)) and len(value) <= most:
        return repr(value)
    return f"<{_count(value)} elements>"
