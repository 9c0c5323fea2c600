"""From a message to CDR, by a function that is compiled once for its type.

The fast function handles the usual case, and only notices unusual values. `checking` alone decides
what is wrong with them.
"""

import struct
from collections.abc import Callable
from typing import Any

from rosbase.wire.cdr import HEADER
from rosbase.wire.checking import made_usual
from rosbase.wire.field_lines import putter
from rosbase.wire.pieces import UnusualError
from rosbase.wire.structure import MessageType
from rosbase.wire.whole import whole_writer

__all__ = ["compiled_writer"]

_UNUSUAL = (
    UnusualError,
    AttributeError,
    OverflowError,
    TypeError,
    UnicodeEncodeError,
    ValueError,
    struct.error,
)


def compiled_writer(of: MessageType, where: str) -> Callable[[Any], bytes]:
    """Return the function that writes messages of a type: objects with its fields.

    It raises TypeError for a value of the wrong kind, and ValueError for one out of the range of
    its field; the text names the field, below `where`.
    """
    put_message = putter(of)

    def write(message: Any) -> bytes:
        parts = [HEADER]
        try:
            put_message(message, parts.append, 0)
        except _UNUSUAL:
            parts = [HEADER]
            put_message(made_usual(message, of, where), parts.append, 0)
        return b"".join(parts)

    return whole_writer(of, _UNUSUAL, write)
