"""Checksums at the end of a line, as `{...}*5A`: verified against the bytes, and removed."""

import binascii
import re
from collections.abc import Callable
from typing import TypeAlias, TypeVar

from rosbase.errors import ParameterError
from rosbase.mapping.rejects import Reject

__all__ = ["CHECKSUMS", "NO_CHECKSUM", "Verify", "compile_checksum", "verified"]

ReadT = TypeVar("ReadT")

NO_CHECKSUM = "none"
"""Value of the parameter for lines without a checksum."""

Verify: TypeAlias = Callable[[bytes], bytes | Reject]
"""Function that returns the frame without its checksum, or why the frame is refused. Never raises.
"""

_HEX = re.compile(rb"[0-9a-fA-F]+")
# What follows a separator and is no longer than this was meant to be a checksum.
_LONGEST_TAIL = 10


def _xor(data: bytes) -> int:
    """Return the checksum of NMEA 0183: all bytes, exclusive or."""
    total = 0
    for byte in data:
        total ^= byte
    return total


def _crc16_modbus(data: bytes) -> int:
    """Return the CRC with polynomial 0x8005, reflected, from 0xFFFF."""
    crc = 0xFFFF
    for byte in data:
        crc = crc >> 8 ^ _MODBUS[(crc ^ byte) & 0xFF]
    return crc


def _modbus_entry(byte: int) -> int:
    for _ in range(8):
        byte = byte >> 1 ^ 0xA001 if byte & 1 else byte >> 1
    return byte


_MODBUS = [_modbus_entry(byte) for byte in range(256)]


def _crc16_ccitt(data: bytes) -> int:
    """Return the CRC with polynomial 0x1021, from 0xFFFF: CCITT-FALSE, or IBM-3740."""
    return binascii.crc_hqx(data, 0xFFFF)


def _crc16_xmodem(data: bytes) -> int:
    """Return the CRC with polynomial 0x1021, from 0."""
    return binascii.crc_hqx(data, 0)


def _crc32(data: bytes) -> int:
    """Return the CRC with polynomial 0x04C11DB7, reflected: the one of zlib, zip and Ethernet."""
    return binascii.crc32(data)


CHECKSUMS: dict[str, tuple[Callable[[bytes], int], int]] = {
    "xor": (_xor, 2),
    "crc16_modbus": (_crc16_modbus, 4),
    "crc16_ccitt": (_crc16_ccitt, 4),
    "crc16_xmodem": (_crc16_xmodem, 4),
    "crc32": (_crc32, 8),
}
"""Checksums of bytes by name, with their numbers of hexadecimal digits."""


def compile_checksum(kind: str, separator: str = "*") -> Verify:
    """Return the function that verifies lines.

    A `$` at the start of a line is not covered, and is removed too, as in NMEA sentences.

    Args:
        kind: One of CHECKSUMS.
        separator: Text between the covered bytes and the digits.

    Raises:
        ParameterError: The separator cannot be told from the digits.
    """
    compute, digits = CHECKSUMS[kind]
    mark = separator.encode()
    if not mark.strip() or _HEX.fullmatch(mark.strip()):
        raise ParameterError(
            f"parameter checksum_separator takes text such as *, no digits, not {separator!r}"
        )

    def verify(frame: bytes) -> bytes | Reject:
        content, found, tail = frame.rpartition(mark)
        tail = tail.rstrip(b"\r\n \t\0")
        if not found or len(tail) > _LONGEST_TAIL:
            return Reject("no_checksum")
        if len(tail) != digits or not _HEX.fullmatch(tail):
            return Reject("bad_checksum", f"{digits} hexadecimal digits must follow {separator}")
        content = content.removeprefix(b"$")
        due = compute(content)
        if due != int(tail, 16):
            return Reject("bad_checksum", f"{kind} of the line is {due:0{digits}X}")
        return content

    return verify


def verified(
    verify: Verify, read: Callable[[bytes], ReadT | Reject]
) -> Callable[[bytes], ReadT | Reject]:
    """Return a reader that verifies and removes the checksum before `read`."""

    def read_verified(frame: bytes) -> ReadT | Reject:
        content = verify(frame)
        if not isinstance(content, Reject):
            return read(content)
        # Text that is no data anyway, as at the start of a device, is refused for that.
        unsigned = read(frame) if content.reason == "no_checksum" else None
        return unsigned if isinstance(unsigned, Reject) else content

    return read_verified
