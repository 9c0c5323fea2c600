"""Write a message in one call of `struct`: a message of numbers, and at most one text.

Most sensor messages are like that. Their layout depends only on the length of the text, which is
usually the frame: the same text in each message.
"""

from collections.abc import Callable
from typing import Any

from rosbase.messages.widths import Width
from rosbase.wire.cdr import HEADER, Run
from rosbase.wire.field_lines import SHORT, Body, is_number
from rosbase.wire.source import Source
from rosbase.wire.structure import Field, Kind, MessageType

__all__ = ["whole_writer"]

_Pack = Callable[..., bytes]


def whole_writer(
    of: MessageType, unusual: tuple[type[Exception], ...], otherwise: Callable[[Any], bytes]
) -> Callable[[Any], bytes]:
    """Return the function that writes messages of a type.

    Args:
        of: The type.
        unusual: Exceptions that tell of a value that the function does not take.
        otherwise: Writes messages with such a value or a long text. It is returned as it is for a
            type with fields of other kinds.
    """
    texts = _count_texts(of)
    if texts is None or texts > 1:
        return otherwise
    source = Source("write(message)")
    slow = source.name_of(otherwise, "otherwise")
    with source.block("try:"):
        body = _Body(source, slow)
        body.put_message(of, "message")
        header = source.name_of(HEADER, "header")
        pack = "pack" if texts else source.name_of(body.layout(0), "pack")
        source.line(f"return {pack}({', '.join([header, *body.values])})")
    with source.block(f"except {source.name_of(unusual, 'unusual')}:"):
        source.line(f"return {slow}(message)")
    return source.compile()


class _Body(Body):
    """The lines that put a whole message."""

    def __init__(self, source: Source, otherwise: str) -> None:
        super().__init__(source)
        self._otherwise = otherwise
        # By length of the text.
        self._packs: list[_Pack | None] = [None] * SHORT
        self._text_at: int | None = None

    def put_message(self, of: MessageType, message: str) -> None:
        """Add the lines that read the fields of the message and check their values."""
        self.put_fields(of, message)
        if not of.fields:
            self.add_number("0", "B")
        if self.faults:
            self.refuse(" or ".join(self.faults))

    def layout(self, length: int) -> _Pack:
        """Return the function that packs a message whose text has that length."""
        codes = list(self.codes)
        if self._text_at is not None:
            codes[self._text_at] = f"{length}s"
        return Run(codes).whole().pack

    def encoded(self, one: Field, value: str) -> str:
        """Add the lines that encode the text and find `pack`, which packs a message with it."""
        source, text = self.source, super().encoded(one, value)
        find = source.name_of(self._find_layout, "find")
        source.line(f"size = len({text})")
        with source.block(f"if size >= {SHORT}:"):
            source.line(f"return {self._otherwise}(message)")
        source.line(f"pack = {source.name_of(self._packs, 'packs')}[size] or {find}(size)")
        return text

    def put_bytes(self, data: str, count: str) -> None:
        """Put the text, and its length in front."""
        self.add_number(count, "I")
        self._text_at = len(self.codes)
        self.codes.append("s")
        self.values.append(data)

    def _find_layout(self, length: int) -> _Pack:
        pack = self._packs[length] = self.layout(length)
        return pack


def _count_texts(of: MessageType) -> int | None:
    """Return the number of texts of a message; None if something else varies in size."""
    number = 0
    for one in of.fields:
        if one.kind is Kind.ONE and isinstance(one.element, MessageType):
            within = _count_texts(one.element)
            if within is None:
                return None
            number += within
        elif one.kind is Kind.ONE and one.element is Width.STRING:
            number += 1
        elif one.kind is Kind.SEQUENCE or one.is_buffer or not is_number(one):
            return None
    return number
