"""Buffers: many numbers in a message that nobody copies, so nobody may change them."""

import functools
import inspect
import sys
import typing
from array import array
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from attrs import Attribute, field

from rosbase.messages.marks import Fixed, Numbers
from rosbase.messages.pickling import make_picklable
from rosbase.messages.widths import TYPECODES, Width, is_of

__all__ = ["numbers", "protect_buffers"]

_MARK = "rosbase.buffer"
# What numpy calls them; a byte of ROS has no sign.
_NUMPY_NAMES = {Width.BYTE: "uint8", Width.CHAR: "uint8"}


class _Rule:
    """Width and size of a buffer, to check and compare it.

    It is no class of attrs, because those cost time at the start.
    """

    __slots__ = ("size", "width")

    def __init__(self, width: Width, size: int | None) -> None:
        self.width = width
        self.size = size

    def check(self, name: str, given: Any) -> None:
        """Refuse what cannot be a buffer of that kind."""
        reason = _fault(given, self.width)
        if reason:
            raise TypeError(f"{name} {reason}")
        if self.size is not None and _count(given) != self.size:
            raise ValueError(f"{name} takes {self.size} elements, not {_count(given)}")

    def plain(self, value: Any) -> Any:
        """Return what is equal for equal numbers, whatever object holds them."""
        try:
            return _bytes_of(value, TYPECODES[self.width])
        except (TypeError, ValueError, OverflowError):
            # It holds something else, and is only equal to the same.
            return value


def numbers(width: Width, size: int | None = None) -> Any:
    """Return a field for a buffer of numbers of that width: any number of them, or `size`.

    A buffer that can be changed is refused, because a subscriber gets the same one. Two buffers
    are equal if their bytes are, whatever object holds them: NaN equals itself, and 0.0 differs
    from -0.0.
    """
    rule = _Rule(width, size)

    def check(instance: object, attribute: "Attribute[Any]", given: Any) -> None:
        rule.check(attribute.name, given)

    empty: Any = b"" if TYPECODES[width] == "B" else ()
    default = empty if size is None else (0,) * size
    return field(
        default=default, validator=check, eq=rule.plain, repr=_shown, metadata={_MARK: rule}
    )


def protect_buffers(cls: Any) -> None:
    """Have a frozen class check, compare and pickle its buffers.

    `numbers` does the first two for its field. For other fields, as those of a dataclass, the
    constructor and the comparison of the class do it.
    """
    declared = _fields_of(cls)
    hints = {one.name: _evaluated(cls, one.type) for one in declared}
    rules = {name: rule for name, hint in hints.items() if (rule := _rule_of(hint))}
    # An annotation that cannot be evaluated yet may be one.
    if rules or any(isinstance(hint, str) for hint in hints.values()):
        make_picklable(cls)
    rest = {one.name: rules.get(one.name) for one in declared if _MARK not in one.metadata}
    unchecked = {name: rule for name, rule in rest.items() if rule}
    if unchecked:
        _check_in_constructor(cls, unchecked)
        if _is_generated(cls.__eq__):
            _compare_by_bytes(cls, declared, unchecked)


def _fields_of(cls: Any) -> list[Any]:
    """Return the fields of an attrs class or a dataclass."""
    own = vars(cls)
    return list(own.get("__attrs_attrs__") or own.get("__dataclass_fields__", {}).values())


def _evaluated(cls: Any, hint: Any) -> Any:
    """Return an annotation; one that is a text as what it says, if that can be known."""
    if not isinstance(hint, str):
        return hint
    stand_in = SimpleNamespace(__annotations__={"hint": hint})
    known = vars(sys.modules[cls.__module__]) if cls.__module__ in sys.modules else {}
    try:
        return typing.get_type_hints(stand_in, known, include_extras=True)["hint"]
    except Exception:
        return hint


def _rule_of(hint: Any) -> _Rule | None:
    marks = getattr(hint, "__metadata__", ())
    width = next((mark.width for mark in marks if isinstance(mark, Numbers)), None)
    size = next((mark.size for mark in marks if isinstance(mark, Fixed)), None)
    return None if width is None else _Rule(width, size)


def _check_in_constructor(cls: Any, rules: dict[str, _Rule]) -> None:
    construct = cls.__init__

    @functools.wraps(construct)
    def construct_and_check(self: Any, *args: Any, **kwargs: Any) -> None:
        construct(self, *args, **kwargs)
        for name, rule in rules.items():
            rule.check(name, getattr(self, name))

    cls.__init__ = construct_and_check


def _compare_by_bytes(cls: Any, declared: list[Any], rules: dict[str, _Rule]) -> None:
    """Replace the comparison that attrs or dataclasses have generated."""
    keys: list[tuple[str, Callable[[Any], Any]]] = []
    for one in declared:
        if one.compare if hasattr(one, "compare") else one.eq:
            own = getattr(one, "eq_key", None) or _same
            keys.append((one.name, rules[one.name].plain if one.name in rules else own))

    def key(self: Any) -> tuple[Any, ...]:
        return tuple(plain(getattr(self, name)) for name, plain in keys)

    def is_equal(self: Any, other: object) -> bool:
        return key(self) == key(other) if type(other) is type(self) else NotImplemented

    def hash_of(self: Any) -> int:
        return hash(key(self))

    cls.__eq__ = is_equal
    if cls.__hash__ is not None and _is_generated(cls.__hash__):
        cls.__hash__ = hash_of


def _is_generated(method: Any) -> bool:
    """Return whether a method was made by attrs or dataclasses, and not written by the program."""
    code = getattr(inspect.unwrap(method), "__code__", None)
    return code is not None and code.co_filename.startswith("<")


def _same(value: Any) -> Any:
    return value


def _fault(value: Any, width: Width) -> str:
    """Return why a value cannot be a buffer of numbers; empty if it can."""
    typecode = TYPECODES[width]
    if isinstance(value, (tuple, bytes)):
        is_wrong = isinstance(value, bytes) and typecode != "B"
        return "takes numbers of another width than bytes have" if is_wrong else ""
    try:
        view = memoryview(value)
    except (TypeError, ValueError):
        return f"takes a tuple or a read-only buffer, not {type(value).__name__}"
    if not view.readonly:
        return (
            "takes a buffer that nobody can change: use bytes(...), memoryview(...).toreadonly(),"
            " or array.setflags(write=False) of numpy"
        )
    if not view.c_contiguous:
        return "takes a contiguous buffer: use numpy.ascontiguousarray(...)"
    if not is_of(view, typecode):
        name = _NUMPY_NAMES.get(width, width.value)
        return (
            f"takes {name} numbers, not those of the format {view.format!r}: use"
            f" array.astype(numpy.{name})"
        )
    return ""


def _count(value: Any) -> int:
    if isinstance(value, (tuple, bytes)):
        return len(value)
    # The length of an array of several dimensions is that of the first.
    view = memoryview(value)
    return view.nbytes // view.itemsize


def _bytes_of(value: Any, typecode: str) -> bytes:
    if not isinstance(value, tuple):
        return memoryview(value).tobytes()
    return bytes(value) if typecode == "?" else array(typecode, value).tobytes()


def _shown(value: Any) -> str:
    most = 16 if isinstance(value, tuple) else 64
    if isinstance(value, (tuple, bytes)) and len(value) <= most:
        return repr(value)
    return f"<{_count(value)} elements>"
