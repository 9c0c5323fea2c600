"""The lines of a function that puts a message behind others, run by run of numbers."""

import functools
import struct
from collections.abc import Callable
from typing import Any

from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.cdr import SIZES, Run
from rosbase.wire.pieces import (
    WIDE_SIZE,
    UnusualError,
    packer,
    put_texts,
    put_wide_texts,
    text_of,
    wide_text_of,
)
from rosbase.wire.source import Source
from rosbase.wire.structure import Field, Kind, MessageType

__all__ = ["SHORT", "Body", "is_number", "putter"]

_PYTHON_TYPES = {"f": float, "d": float, "?": bool}
# No value of a message: not even a wrong one, such as None, is taken for it.
_NOTHING = object()
SHORT = 256
"""Texts of this length and longer are not remembered."""
_PADDING = tuple(bytes(count) for count in range(8))


@functools.cache
def putter(of: MessageType) -> Callable[[Any, Callable[[bytes], object], int], int]:
    """Return the function that puts a message behind others, and returns where it ends."""
    source = Source("put_message(message, put, pos)")
    body = Body(source)
    body.put_fields(of, "message")
    if not of.fields:
        body.add_number("0", "B")
    body.end_run()
    source.line("return pos")
    return source.compile()


class Body:
    """The lines that put the fields of a message, run by run."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.codes: list[str] = []
        self.values: list[str] = []
        self.faults: list[str] = []

    def put_fields(self, of: MessageType, message: str) -> None:
        """Add the fields of a message that is in a variable of that name."""
        for one in of.fields:
            value = f"{message}.{one.name}"
            if one.kind is Kind.ONE:
                self._put_one(one, value)
            elif one.kind is Kind.ARRAY and is_number(one) and not one.is_buffer:
                self._put_array(one, value)
            else:
                self._put_many(one, value)

    def add_number(self, value: str, code: str, python_type: type | None = None) -> None:
        """Add a number to the run.

        Args:
            value: The expression of its value.
            code: Its code in `struct`.
            python_type: The type that it must have; None if it certainly has.
        """
        if python_type is not None:
            # struct would take a bool for a number, and anything for a bool.
            number = self.source.new("number")
            wanted = self.source.name_of(python_type, python_type.__name__)
            self.source.line(f"{number} = {value}")
            self.faults.append(f"type({number}) is not {wanted}")
            value = number
        self.codes.append(code)
        self.values.append(value)

    def end_run(self) -> None:
        """Put the numbers of the run."""
        if not self.codes:
            return
        source = self.source
        layouts = source.name_of(tuple(Run(self.codes).layouts()), "layouts")
        if self.faults:
            self.refuse(" or ".join(self.faults))
        source.line(f"layout = {layouts}[pos & 7]")
        source.line(f"put(layout.pack({', '.join(self.values)}))")
        source.line("pos += layout.size")
        self.codes, self.values, self.faults = [], [], []

    def _put_one(self, one: Field, value: str) -> None:
        source = self.source
        if isinstance(one.element, MessageType):
            if one.element.fields:
                part = source.new("part")
                source.line(f"{part} = {value}")
                self.put_fields(one.element, part)
            else:
                self.add_number("0", "B")
        elif one.element is Width.STRING:
            text = self.encoded(one, value)
            self.put_bytes(text, f"len({text})")
        elif one.element is Width.WSTRING:
            text = source.new("text")
            encode = source.name_of(wide_text_of, "wide_text_of")
            source.line(f"{text} = {encode}({value}, {one.text_limit})")
            self.put_bytes(text, f"len({text}) // {WIDE_SIZE}")
        else:
            code = TYPECODES[one.element]
            self.add_number(value, code, _PYTHON_TYPES.get(code, int))

    def encoded(self, one: Field, value: str) -> str:
        """Add the lines that encode a text; return the variable with its bytes."""
        source, raw, text = self.source, self.source.new("raw"), self.source.new("text")
        # Such as the frame of a sensor: the same text in each message.
        known = source.name_of([(_NOTHING, b"")], "known")
        encode = source.name_of(text_of, "text_of")
        source.line(f"{raw}, last = {value}, {known}[0]")
        with source.block(f"if {raw} is last[0]:"):
            source.line(f"{text} = last[1]")
        with source.block("else:"):
            source.line(f"{text} = {encode}({raw}, {one.text_limit})")
            with source.block(f"if len({text}) < {SHORT}:"):
                source.line(f"{known}[0] = {raw}, {text}")
        return text

    def put_bytes(self, data: str, count: str) -> None:
        """Put a text that is in a variable, and its length in front."""
        self.add_number(count, "I")
        self.end_run()
        self.source.line(f"put({data})")
        self.source.line(f"pos += len({data})")

    def _put_array(self, one: Field, value: str) -> None:
        assert isinstance(one.element, Width)
        code = TYPECODES[one.element]
        source, many = self.source, self.source.new("many")
        source.line(f"{many} = {value}")
        # Such as the covariance of a sensor: the same tuple in each message, and tuples of numbers
        # do not change.
        packed, known = source.new("packed"), source.name_of([(_NOTHING, b"")], "known")
        types = source.name_of((_PYTHON_TYPES.get(code, int),) * one.size, "types")
        pack = source.name_of(struct.Struct(f"<{one.size}{code}").pack, "pack")
        source.line(f"last = {known}[0]")
        with source.block(f"if {many} is last[0]:"):
            source.line(f"{packed} = last[1]")
        with source.block("else:"):
            # One that is too short beside one that is too long would pass for two that are right.
            self.refuse(f"type({many}) is not tuple or tuple(map(type, {many})) != {types}")
            source.line(f"{packed} = {pack}(*{many})")
            source.line(f"{known}[0] = {many}, {packed}")
        self.codes.append(f"{one.size}{code}")
        self.values.append(packed)

    def refuse(self, condition: str) -> None:
        """Have the function take no message for which a condition holds."""
        unusual = self.source.name_of(UnusualError, "Unusual")
        with self.source.block(f"if {condition}:"):
            self.source.line(f"raise {unusual}")

    def _put_many(self, one: Field, value: str) -> None:
        source = self.source
        many = source.new("many")
        if is_number(one):
            assert isinstance(one.element, Width)
            pack = source.name_of(packer(TYPECODES[one.element]), "pack")
            count = source.new("count")
            source.line(f"{many}, {count} = {pack}({value})")
        else:
            count = f"len({many})"
            source.line(f"{many} = {value}")
            self.refuse(f"type({many}) is not tuple and type({many}) is not list")
        if one.size:
            self.refuse(f"{count} {'!=' if one.kind is Kind.ARRAY else '>'} {one.size}")
        if one.kind is Kind.SEQUENCE:
            self.add_number(count, "I")
        self.end_run()
        self._put_elements(one, many)

    def _put_elements(self, one: Field, many: str) -> None:
        source = self.source
        if isinstance(one.element, MessageType):
            put_element = source.name_of(putter(one.element), "put_element")
            with source.block(f"for element in {many}:"):
                source.line(f"pos = {put_element}(element, put, pos)")
        elif one.element in (Width.STRING, Width.WSTRING):
            wide = one.element is Width.WSTRING
            put_all = source.name_of(put_wide_texts if wide else put_texts, "put_texts")
            source.line(f"pos = {put_all}({many}, put, pos, {one.text_limit})")
        else:
            padding = source.name_of(_PADDING, "padding")
            size = SIZES[one.element]
            with source.block(f"if {many}:" if one.kind is Kind.ARRAY else f"if len({many}):"):
                if size > 1:
                    source.line(f"put({padding}[-pos & {size - 1}])")
                    source.line(f"pos += -pos & {size - 1}")
                source.line(f"put({many})")
                source.line(f"pos += len({many})")


def is_number(one: Field) -> bool:
    """Return whether the elements of a field are numbers."""
    return isinstance(one.element, Width) and one.element in TYPECODES
