"""From CDR to a message, by a function that is compiled once for its type and byte order.

`Make` decides what a message becomes: an object of its class, or plain data.
"""

import functools
import struct
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rosbase.errors import WireError
from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.cdr import ORDERS, Run, least_size_of_element
from rosbase.wire.pieces import WIDE_SIZE, read_numbers, read_text, read_view, read_wide_text
from rosbase.wire.source import Source
from rosbase.wire.structure import Field, Kind, MessageType

__all__ = ["Make", "Values", "compiled_reader"]

_HEADER_SIZE = 4

Values: TypeAlias = Sequence[tuple[Field, str]]
"""The fields of a message, each with the expression of its value."""

Make: TypeAlias = Callable[[Source, list[str], MessageType, Values], str]
"""Adds lines that make a message to the list, and returns the expression of it."""


def compiled_reader(of: MessageType, make: Make) -> Callable[[bytes], Any]:
    """Return the function that reads messages of a type.

    It raises WireError for bytes that are no such message. Buffers of the message are views of the
    bytes, without a copy.
    """

    def read(data: bytes) -> Any:
        order = ORDERS.get(bytes(data[:2]))
        if order is None:
            raise WireError(f"{of.name}: the bytes do not begin as CDR does")
        # What can be changed is copied: a message cannot be.
        view = memoryview(data)
        view = view if view.readonly else memoryview(bytes(view))
        try:
            return _getter(of, order, make)(view, _HEADER_SIZE)[0]
        except WireError as error:
            raise WireError(f"{of.name}: {error}") from None
        except struct.error:
            raise WireError(f"{of.name}: the message is cut short") from None
        except (TypeError, ValueError) as error:
            # Also of a class of the program that checks its fields.
            raise WireError(f"{of.name}: {error}") from None

    return read


@functools.cache
def _getter(
    of: MessageType, order: str, make: Make
) -> Callable[[memoryview, int], tuple[Any, int]]:
    """Return the function that gets a message, and where it ends."""
    source = Source("get_message(data, pos)")
    body = _Body(source, order, make)
    message = body.get_message(of)
    body.end_run()
    made = message()
    for line in body.building:
        source.line(line)
    source.line(f"return {made}, pos")
    return source.compile()


# An expression, which is known only when the run that it is in has been read.
_Later = Callable[[], str]


class _Body:
    """The lines that get the fields of a message, run by run."""

    def __init__(self, source: Source, order: str, make: Make) -> None:
        self._source = source
        self._order = order
        self._make = make
        self._codes: list[str] = []
        self._values = source.new("values")
        self.building: list[str] = []
        """Lines that make messages, when all has been read."""

    def get_message(self, of: MessageType) -> _Later:
        """Get the fields of a message; return the expression of the message."""
        if not of.fields:
            self._number("B")
        found = [(one, self._get(one)) for one in of.fields]
        return lambda: self._make(
            self._source, self.building, of, [(one, value()) for one, value in found]
        )

    def end_run(self) -> None:
        """Read the numbers of the run."""
        if not self._codes:
            return
        source = self._source
        layouts = Run("".join(self._codes)).layouts(self._order)
        # The four bytes in front do not count for the padding.
        shifted = source.name_of(tuple(layouts[4:] + layouts[:4]), "layouts")
        source.line(f"layout = {shifted}[pos & 7]")
        source.line(f"{self._values} = layout.unpack_from(data, pos)")
        source.line("pos += layout.size")
        self._codes, self._values = [], source.new("values")

    def _get(self, one: Field) -> _Later:
        if one.kind is Kind.ONE:
            return self._get_one(one)
        is_number = isinstance(one.element, Width) and one.element in TYPECODES
        if one.kind is Kind.ARRAY and is_number and not one.is_buffer:
            assert isinstance(one.element, Width)
            return self._numbers(TYPECODES[one.element], one.size)
        return self._get_many(one)

    def _number(self, code: str) -> _Later:
        values, index = self._values, len("".join(self._codes))
        self._codes.append(code)
        return lambda: f"{values}[{index}]"

    def _numbers(self, code: str, size: int) -> _Later:
        values, index = self._values, len("".join(self._codes))
        self._codes.append(code * size)
        return lambda: f"{values}[{index}:{index + size}]"

    def _get_one(self, one: Field) -> _Later:
        if isinstance(one.element, MessageType):
            return self.get_message(one.element)
        if one.element in TYPECODES:
            return self._number(TYPECODES[one.element])
        source, size = self._source, self._number("I")
        self.end_run()
        text = source.new("text")
        if one.element is Width.STRING:
            read = source.name_of(read_text, "read_text")
            source.line(f"{text} = {read}(data, pos, {size()})")
            source.line(f"pos += {size()}")
        else:
            read = source.name_of(read_wide_text, "read_wide_text")
            source.line(f"{text} = {read}(data, pos, {size()}, {self._order!r})")
            source.line(f"pos += {WIDE_SIZE} * {size()}")
        return lambda: text

    def _get_many(self, one: Field) -> _Later:
        source = self._source
        count = str(one.size)
        if one.kind is Kind.SEQUENCE:
            number = self._number("I")
            self.end_run()
            count = source.new("count")
            source.line(f"{count} = {number()}")
            if one.size:
                self._refuse(f"{count} > {one.size}", count)
        else:
            self.end_run()
        if isinstance(one.element, Width) and one.element in TYPECODES:
            return self._get_numbers(one, TYPECODES[one.element], count)
        # Compared before anything is allocated: the count may be anything.
        self._refuse(f"{count} * {least_size_of_element(one)} > len(data) - pos", count)
        return self._get_elements(one, count)

    def _get_numbers(self, one: Field, code: str, count: str) -> _Later:
        source, many = self._source, self._source.new("many")
        read = source.name_of(
            *((read_view, "read_view") if one.is_buffer else (read_numbers, "read"))
        )
        size = struct.calcsize(f"={code}")
        with source.block(f"if {count}:"):
            if size > 1:
                source.line(f"pos += -pos + 4 & {size - 1}")
            source.line(f"{many} = {read}(data, pos, {count}, {code!r}, {self._order!r})")
            source.line(f"pos += {size} * {count}")
        with source.block("else:"):
            source.line(f"{many} = {'b' + repr('') if one.is_buffer and code == 'B' else '()'}")
        return lambda: many

    def _get_elements(self, one: Field, count: str) -> _Later:
        source, many = self._source, self._source.new("many")
        source.line(f"{many} = []")
        with source.block(f"for _ in range({count}):"):
            if isinstance(one.element, MessageType):
                get = source.name_of(_getter(one.element, self._order, self._make), "get")
                source.line(f"element, pos = {get}(data, pos)")
            else:
                length = source.name_of(struct.Struct(f"{self._order}I").unpack_from, "length")
                source.line("pos += -pos & 3")
                source.line(f"(size,) = {length}(data, pos)")
                if one.element is Width.STRING:
                    read = source.name_of(read_text, "read_text")
                    source.line(f"element = {read}(data, pos + 4, size)")
                    source.line("pos += 4 + size")
                else:
                    read = source.name_of(read_wide_text, "read_wide_text")
                    source.line(f"element = {read}(data, pos + 4, size, {self._order!r})")
                    source.line(f"pos += 4 + {WIDE_SIZE} * size")
            source.line(f"{many}.append(element)")
        return lambda: f"tuple({many})"

    def _refuse(self, condition: str, count: str) -> None:
        error = self._source.name_of(WireError, "Error")
        with self._source.block(f"if {condition}:"):
            text = "elements are announced, which is more than there can be"
            self._source.line(f"raise {error}(f'{{{count}}} {text}')")
