"""Packs values as MessagePack, CBOR and protobuf do, for frames that are none of JSON."""

import struct
from typing import Any

__all__ = ["cbor", "message_pack", "protobuf"]


def message_pack(value: Any) -> bytes:
    match value:
        case None:
            return b"\xc0"
        case bool():
            return b"\xc3" if value else b"\xc2"
        case int() if 0 <= value < 128:
            return bytes([value])
        case int() if -(2**31) <= value < 2**31:
            return b"\xd2" + struct.pack(">i", value)
        case int():
            return b"\xd3" + struct.pack(">q", value)
        case float():
            return b"\xcb" + struct.pack(">d", value)
        case str():
            data = value.encode()
            head = bytes([0xA0 | len(data)]) if len(data) < 32 else b"\xda" + _two(data)
            return head + data
        case list():
            head = bytes([0x90 | len(value)]) if len(value) < 16 else b"\xdc" + _two(value)
            return head + b"".join(message_pack(item) for item in value)
        case dict():
            head = bytes([0x80 | len(value)]) if len(value) < 16 else b"\xde" + _two(value)
            return head + b"".join(message_pack(k) + message_pack(v) for k, v in value.items())
    raise TypeError(value)


def cbor(value: Any) -> bytes:
    match value:
        case None:
            return b"\xf6"
        case bool():
            return b"\xf5" if value else b"\xf4"
        case int():
            return _head(0, value) if value >= 0 else _head(1, -1 - value)
        case float():
            return b"\xfb" + struct.pack(">d", value)
        case str():
            return _head(3, len(value.encode())) + value.encode()
        case list():
            return _head(4, len(value)) + b"".join(cbor(item) for item in value)
        case dict():
            return _head(5, len(value)) + b"".join(cbor(k) + cbor(v) for k, v in value.items())
    raise TypeError(value)


def protobuf(numbers: list[float]) -> bytes:
    """Fields 1, 2, ... of kind float, as nanopb writes a message of them."""
    return b"".join(
        bytes([number << 3 | 5]) + struct.pack("<f", value)
        for number, value in enumerate(numbers, start=1)
    )


def _two(value: Any) -> bytes:
    return struct.pack(">H", len(value))


def _head(major: int, value: int) -> bytes:
    if value < 24:
        return bytes([major << 5 | value])
    for code, (layout, limit) in enumerate([("B", 8), ("H", 16), ("I", 32), ("Q", 64)]):
        if value < 2**limit:
            return bytes([major << 5 | 24 + code]) + struct.pack(f">{layout}", value)
    raise OverflowError(value)
