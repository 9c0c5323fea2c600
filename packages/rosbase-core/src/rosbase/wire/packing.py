"""Write the bytes of messages of which only some numbers vary: everything else is prepared once."""

import struct
from collections.abc import Callable, Sequence
from typing import Any

from attrs import frozen

from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.cdr import HEADER, SIZES
from rosbase.wire.class_writer import writer
from rosbase.wire.description import Field, Kind, MessageType, describe
from rosbase.wire.pieces import text_of, wide_text_of
from rosbase.wire.source import Source
from rosbase.wire.varying import NS_PER_S, TIMES, arguments_of, is_within, kind_of

__all__ = ["packer"]


def packer(template: Any, varying: Sequence[str]) -> Callable[..., bytes]:
    """Return a function that gives the CDR of what `maker` makes, without making it.

    Raises:
        TypeError: The template is no message, or a field has a value of the wrong kind.
        ValueError: A path leads to no numbers, or a value is out of the range of its field.
    """
    own = describe(type(template))
    arguments = arguments_of(own, varying)
    whole = writer(own.cls)(template)
    layout = _Layout()
    layout.walk(own, template)
    source = Source(f"pack({', '.join(arguments.values())})")
    form, values, end = "<", [], 0
    for path, argument in arguments.items():
        if kind_of(own, path) in TIMES:
            source.line(f"{argument}_s, {argument}_n = divmod({argument}, {NS_PER_S})")
    for leaf in layout.leaves:
        found = next((path for path in arguments if is_within(leaf.path, path)), None)
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


def _leaf_values(
    own: MessageType, layout: _Layout, leaf: _Leaf, path: str, argument: str
) -> list[str]:
    """Return the expressions of the numbers of one leaf of a varying field."""
    if kind_of(own, path) in TIMES:
        return [f"{argument}_s" if leaf.path.endswith(".sec") else f"{argument}_n"]
    within = [other for other in layout.leaves if is_within(other.path, path)]
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
