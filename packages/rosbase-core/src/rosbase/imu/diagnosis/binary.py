"""Known binary formats: compressed, packed, or the protocol of a sensor."""

import zlib
from collections.abc import Callable
from itertools import islice

from rosbase.imu.diagnosis.cause import Cause
from rosbase.imu.diagnosis.walkers import is_cbor, is_message_pack, is_protobuf

__all__ = ["diagnose_binary"]

# How each begins, and what it is. Sources are the formats' own specifications and the manuals of
# the sensors.
_BEGINNINGS: tuple[tuple[bytes, str], ...] = (
    (b"\x1f\x8b", "compressed with gzip; the sender must not compress it"),
    (b"\x28\xb5\x2f\xfd", "compressed with zstd; the sender must not compress it"),
    (b"\x04\x22\x4d\x18", "compressed with lz4; the sender must not compress it"),
    (b"BZh", "compressed with bzip2; the sender must not compress it"),
    (b"\xfd7zXZ\0", "compressed with xz; the sender must not compress it"),
    (b"PK\x03\x04", "a zip file"),
    (b"\xff\xd8\xff", "a JPEG image, as of a camera"),
    (b"\x89PNG", "a PNG image"),
    (b"\xb5\x62", "UBX, the binary protocol of a u-blox receiver"),
    (b"\x75\x65", "MIP, the binary protocol of a MicroStrain sensor"),
    (b"\xfa\xff", "Xbus, the binary protocol of an Xsens sensor"),
    (b"\xff\x5a", "the binary protocol of an SBG sensor"),
    (b"\xaa\x44", "the binary protocol of a NovAtel receiver"),
    (b"\xd3\x00", "RTCM, corrections for a GPS receiver"),
    (b"\xbb\x00", "the binary protocol of a BNO055 on a UART"),
    (b"\xfa", "binary data of a VectorNav sensor, or of another that begins with 0xFA"),
)
# WitMotion: 0x55, the kind of the packet, eight bytes, a checksum.
_WIT_KINDS = range(0x50, 0x60)
_WIT_LENGTH = 11
# MAVLink: the mark of its version, the length of the payload, and so many bytes around it.
_MAVLINK = {0xFE: (8,), 0xFD: (12, 25)}
_ZLIB_METHOD = 8
_SLIP_END = 0xC0
_MARKS = (
    (b"\xff\xfe\0\0", "UTF-32"),
    (b"\0\0\xfe\xff", "UTF-32"),
    (b"\xff\xfe", "UTF-16"),
    (b"\xfe\xff", "UTF-16"),
)


def diagnose_binary(frame: bytes) -> Cause | None:
    """Return the binary format of a frame, if it is a known one that is not text."""
    for find in (_wide_text, _by_beginning, _by_structure, _packed, _one_byte):
        what = find(frame)
        if what:
            return Cause(what)
    return None


def _wide_text(frame: bytes) -> str:
    for mark, encoding in _MARKS:
        # Two bytes may be anything; text of that kind has a zero in each of its letters.
        if frame.startswith(mark) and frame.count(0) * 4 >= len(frame):
            return f"text in {encoding}; the sender must encode it as UTF-8"
    halves = (frame[1::2], frame[0::2])
    if len(frame) > 4 and any(not any(half) for half in halves) and any(frame):
        return "text in UTF-16; the sender must encode it as UTF-8"
    return ""


def _by_beginning(frame: bytes) -> str:
    return next((what for beginning, what in _BEGINNINGS if frame.startswith(beginning)), "")


def _by_structure(frame: bytes) -> str:
    checks: tuple[tuple[Callable[[bytes], bool], str], ...] = (
        (_is_zlib, "compressed with zlib; the sender must not compress it"),
        (_is_wit, "the binary protocol of a WitMotion sensor"),
        (_is_mavlink, "MAVLink, the protocol of an autopilot"),
        (_is_mqtt, "a packet of MQTT, as on a connection to a broker"),
        (_is_bson, "BSON; the sender must encode it as JSON"),
        (_is_slip, "packets in SLIP; the sender must send lines of JSON"),
    )
    return next((what for check, what in checks if check(frame)), "")


def _packed(frame: bytes) -> str:
    # Each reads the whole frame as its format would. Little passes by chance.
    if is_cbor(frame):
        return "CBOR; the sender must encode it as JSON"
    if is_message_pack(frame):
        return "MessagePack; the sender must encode it as JSON"
    if is_protobuf(frame):
        return "a message of protobuf, by its look; the sender must encode it as JSON"
    return ""


def _one_byte(frame: bytes) -> str:
    kinds = set(islice(frame, 200))
    if len(frame) > 3 and len(kinds) == 1 and kinds <= {0x00, 0xFF}:
        return f"nothing but bytes {frame[0]:#04x}"
    return ""


def _is_zlib(frame: bytes) -> bool:
    if len(frame) < 8 or frame[0] & 0x0F != _ZLIB_METHOD or (frame[0] << 8 | frame[1]) % 31:
        return False
    try:
        zlib.decompressobj().decompress(frame, 64)
    except zlib.error:
        return False
    return True


def _is_wit(frame: bytes) -> bool:
    packet = frame[:_WIT_LENGTH]
    is_begun = len(packet) > 1 and packet[0] == 0x55 and packet[1] in _WIT_KINDS
    return is_begun and (len(packet) < _WIT_LENGTH or sum(packet[:-1]) & 0xFF == packet[-1])


def _is_mavlink(frame: bytes) -> bool:
    lengths = _MAVLINK.get(frame[0], ()) if len(frame) > 7 else ()
    return any(len(frame) >= frame[1] + around for around in lengths)


def _is_mqtt(frame: bytes) -> bool:
    """Return whether it is a PUBLISH with the right length and a text as topic."""
    if len(frame) < 6 or frame[0] >> 4 != 3:
        return False
    at, length, shift = 1, 0, 0
    for byte in frame[1:5]:
        length |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if not byte & 0x80:
            break
    topic_length = int.from_bytes(frame[at : at + 2], "big")
    topic = frame[at + 2 : at + 2 + topic_length]
    return len(frame) == at + length and len(topic) == topic_length > 0 and topic.isascii()


def _is_bson(frame: bytes) -> bool:
    return len(frame) > 6 and int.from_bytes(frame[:4], "little") == len(frame) and not frame[-1]


def _is_slip(frame: bytes) -> bool:
    is_edge = len(frame) > 4 and _SLIP_END in (frame[0], frame[-1])
    return is_edge and frame.count(_SLIP_END) > 1
