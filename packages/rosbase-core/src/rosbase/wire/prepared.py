"""Messages of which only some numbers vary: everything else is prepared once.

A varying field is named by its path, such as `header.stamp` or `orientation`. Its value is, for a
time or a duration, the nanoseconds; for a message of numbers or an array, a sequence of its
numbers; and for a number, the number.
"""

import itertools
import struct
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from attrs import frozen

from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.cdr import HEADER, SIZES
from rosbase.wire.class_writer import writer
from rosbase.wire.description import Field, Kind, MessageType, describe
from rosbase.wire.pieces import text_of, wide_text_of
from rosbase.wire.source import Source

__all__ = ["maker", "packer"]

_TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
_NS_PER_S = 1_000_000_000


def maker(template: Any, varying: Sequence[str]) -> Callable[..., Any]:
    """Return a function that makes messages like the template, of the values of varying fields.

    It checks no value.

    Raises:
        TypeError: The template is no message.
        ValueError: A path leads to no numbers; the text names it.
    """
    own = describe(type(template))
    arguments = _arguments(own, varying)
    source = Source(f"make({', '.join(arguments.values())})")
    source.line(f"return {_expression(source, own, template, '', arguments)}")
    return source.compile()


def packer(template: Any, varying: Sequence[str]) -> Callable[..., bytes]:
    """Return a function that gives the CDR of what `maker` makes, without making it.

    Raises:
        TypeError: The template is no message, or a field has a value of the wrong kind.
        ValueError: A path leads to no numbers, or a value is out of the range of its field.
    """
    own = describe(type(template))
    arguments = _arguments(own, varying)
    whole = writer(own.cls)(template)
    layout = _Layout()
    layout.walk(own, template)
    source = Source(f"pack({', '.join(arguments.values())})")
    form, values, end = "<", [], 0
    for path, argument in arguments.items():
        if _kind_of(own, path) in _TIMES:
            source.line(f"{argument}_s, {argument}_n = divmod({argument}, {_NS_PER_S})")
    for leaf in layout.leaves:
        found = next((path for path in arguments if _is_within(leaf.path, path)), None)
        if found is None:
            continue
        gap = whole[end : leaf.begin]
        if gap:
            form += f"{len(gap)}s"
            values.append(source.name_of(gap, "fixed"))
        form += f"{leaf.count}{leaf.code}"
        values += _leaf_values(own, layout, leaf, found, arguments[found])
        end = leaf.begin + leaf.count * struct.calcsize(f"<{leaf.code}")
    if rest := whole[end:]:
        form += f"{len(rest)}s"
        values.append(source.name_of(rest, "fixed"))
    pack = source.name_of(struct.Struct(form).pack, "pack_all")
    source.line(f"return {pack}({', '.join(values)})")
    return source.compile()


@frozen
class _Leaf:
    """Numbers of one field, one behind the other."""

    path: str
    code: str
    count: int
    begin: int


class _Layout:
    """Where the numbers of a message stand."""

    def __init__(self) -> None:
        self.leaves: list[_Leaf] = []
        self._pos = 0

    def walk(self, of: MessageType, message: Any, prefix: str = "") -> None:
        """Note the numbers of a message and of those within."""
        if not of.fields:
            self._pos += 1
        for one in of.fields:
            self._note(one, getattr(message, one.name), f"{prefix}{one.name}")

    def _note(self, one: Field, value: Any, path: str) -> None:
        if one.kind is Kind.SEQUENCE:
            self._align(4)
            self._pos += 4
        elements = [value] if one.kind is Kind.ONE else value
        if isinstance(one.element, MessageType):
            for number, element in enumerate(elements):
                within = path if one.kind is Kind.ONE else f"{path}[{number}]"
                self.walk(one.element, element, f"{within}.")
        elif one.element in TYPECODES:
            self._note_numbers(one, len(elements), path)
        else:
            for text in elements:
                self._align(4)
                wide = one.element is Width.WSTRING
                self._pos += 4 + len(wide_text_of(text, 0) if wide else text_of(text, 0))

    def _note_numbers(self, one: Field, count: int, path: str) -> None:
        assert isinstance(one.element, Width)
        size = SIZES[one.element]
        if count:
            self._align(size)
            if one.kind is not Kind.SEQUENCE:
                begin = len(HEADER) + self._pos
                self.leaves.append(_Leaf(path, TYPECODES[one.element], count, begin))
            self._pos += size * count

    def _align(self, size: int) -> None:
        self._pos += -self._pos % size


def _arguments(own: MessageType, varying: Sequence[str]) -> dict[str, str]:
    for number, path in enumerate(varying):
        kind = _kind_of(own, path)
        clash = any(
            _is_within(path, other) or _is_within(other, path) for other in varying[:number]
        )
        if kind is None or clash:
            reason = "is named twice" if clash else "has no fixed number of numbers"
            raise ValueError(f"{own.cls.__name__}.{path} cannot vary: it {reason}")
    return {path: f"value{number}" for number, path in enumerate(varying)}


def _kind_of(own: MessageType, path: str) -> str | None:
    """Return the ROS type of a field that can vary; None if it cannot."""
    of: MessageType | Width = own
    one: Field | None = None
    for name in path.split("."):
        if not isinstance(of, MessageType):
            return None
        one = next((field for field in of.fields if field.name == name), None)
        if one is None or (one.kind is not Kind.ONE and isinstance(one.element, MessageType)):
            return None
        of = one.element
    if one is None or _leaf_count(one) is None:
        return None
    return of.name if isinstance(of, MessageType) else of.value


def _leaf_count(one: Field) -> int | None:
    """Return how many numbers a field has; None if that varies, or if it has texts."""
    if one.kind is Kind.SEQUENCE:
        return None
    if not isinstance(one.element, MessageType):
        count = 1 if one.kind is Kind.ONE else one.size
        return count if one.element in TYPECODES else None
    counts = [_leaf_count(field) for field in one.element.fields]
    if None in counts or not counts or one.kind is not Kind.ONE:
        return None
    return sum(count for count in counts if count is not None)


def _leaf_values(
    own: MessageType, layout: _Layout, leaf: _Leaf, path: str, argument: str
) -> list[str]:
    """Return the expressions of the numbers of one leaf of a varying field."""
    if _kind_of(own, path) in _TIMES:
        return [f"{argument}_s" if leaf.path.endswith(".sec") else f"{argument}_n"]
    within = [other for other in layout.leaves if _is_within(other.path, path)]
    if len(within) == 1:
        return [argument if leaf.path == path and leaf.count == 1 else f"*{argument}"]
    first = sum(other.count for other in within[: within.index(leaf)])
    if first == 0 and _is_gapless(within):
        return [f"*{argument}"]
    if _is_gapless(within):
        return []
    return [f"{argument}[{first + number}]" for number in range(leaf.count)]


def _is_gapless(leaves: list[_Leaf]) -> bool:
    ends = [one.begin + one.count * struct.calcsize(f"<{one.code}") for one in leaves]
    return all(end == after.begin for end, after in zip(ends, leaves[1:], strict=False))


def _is_within(path: str, other: str) -> bool:
    return path == other or path.startswith(f"{other}.")


def _expression(
    source: Source, of: MessageType, template: Any, prefix: str, arguments: dict[str, str]
) -> str:
    kind = source.name_of(of.cls, "kind")
    parts = []
    for one in of.fields:
        path, value = f"{prefix}{one.name}", getattr(template, one.name)
        if path in arguments:
            made = _value_made(source, one, arguments[path])
        elif any(varying.startswith(f"{path}.") for varying in arguments):
            assert isinstance(one.element, MessageType)
            made = _expression(source, one.element, value, f"{path}.", arguments)
        else:
            made = source.name_of(value, "fixed")
        parts.append(_argument(one, made))
    return f"{kind}({', '.join(parts)})"


def _value_made(source: Source, one: Field, argument: str) -> str:
    """Return the expression that makes the value of a varying field."""
    if not isinstance(one.element, MessageType):
        return argument if one.kind is Kind.ONE else f"tuple({argument})"
    kind = source.name_of(one.element.cls, "kind")
    if one.element.name in _TIMES:
        return f"{kind}.from_nanoseconds({argument})"
    if all(_is_number(inner) for inner in one.element.fields):
        return f"{kind}(*{argument})"
    return _message_made(source, one.element, argument, itertools.count())


def _argument(one: Field, value: str) -> str:
    # A call with names costs more.
    return f"{one.alias}={value}" if one.is_keyword else value


def _is_number(one: Field) -> bool:
    return one.kind is Kind.ONE and not isinstance(one.element, MessageType)


def _message_made(source: Source, of: MessageType, argument: str, next_: Iterator[int]) -> str:
    """Return the expression that makes a message of the next numbers of the argument."""
    parts = []
    for one in of.fields:
        if isinstance(one.element, MessageType):
            value = _message_made(source, one.element, argument, next_)
        elif one.kind is Kind.ONE:
            value = f"{argument}[{next(next_)}]"
        else:
            first, *_ = (next(next_) for _ in range(one.size))
            value = f"tuple({argument}[{first}:{first + one.size}])"
        parts.append(_argument(one, value))
    return f"{source.name_of(of.cls, 'kind')}({', '.join(parts)})"
