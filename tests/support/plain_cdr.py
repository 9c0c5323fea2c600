"""A second writer of CDR, by the simplest code that follows the standard; it knows the padding."""

import struct
from typing import Any

from rosbase.messages.widths import TYPECODES, Width
from rosbase.wire.description import Field, Kind, MessageType, describe

__all__ = ["PlainCdr"]


class PlainCdr:
    """A message in CDR, number by number."""

    def __init__(self, message: Any, order: str = "<") -> None:
        self._order = order
        self._body = bytearray()
        self._padding: list[int] = []
        self._put_message(message, describe(type(message)))
        self._header = b"\0\1\0\0" if order == "<" else b"\0\0\0\0"

    def data(self) -> bytes:
        """The message, with zeros as padding."""
        return self._header + self._body

    def without_padding(self, data: bytes) -> bytes:
        """Other bytes of the same message, with zeros as padding."""
        clean = bytearray(data)
        for index in self._padding:
            clean[len(self._header) + index] = 0
        return bytes(clean)

    def _put_message(self, message: Any, of: MessageType) -> None:
        for one in of.fields:
            value = getattr(message, one.name)
            if one.kind is Kind.ONE:
                self._put(value, one)
                continue
            values = value.tolist() if hasattr(value, "tolist") else value
            if one.kind is Kind.SEQUENCE:
                self._put_number(len(values), "I")
            for element in values:
                self._put(element, one)
        if not of.fields:
            self._body.append(0)

    def _put(self, value: Any, one: Field) -> None:
        if isinstance(one.element, MessageType):
            self._put_message(value, one.element)
        elif one.element is Width.STRING:
            self._put_number(len(value.encode()) + 1, "I")
            self._body += value.encode() + b"\0"
        elif one.element is Width.WSTRING:
            units = value.encode("utf-16-le")
            self._put_number(len(units) // 2, "I")
            for (unit,) in struct.iter_unpack("<H", units):
                self._put_number(unit, "I")
        else:
            assert isinstance(one.element, Width)
            self._put_number(value, TYPECODES[one.element])

    def _put_number(self, value: Any, code: str) -> None:
        size, begin = struct.calcsize(f"<{code}"), len(self._body)
        self._body += bytes(-begin % size)
        self._padding += range(begin, len(self._body))
        self._body += struct.pack(self._order + code, value)
