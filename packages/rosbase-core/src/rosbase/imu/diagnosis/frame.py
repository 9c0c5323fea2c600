"""Diagnose a frame that could not be decoded. Pure; for frames that are logged, one at a time."""

import json

from rosbase.imu.diagnosis.binary import diagnose_binary
from rosbase.imu.diagnosis.cause import Cause
from rosbase.imu.diagnosis.json_text import diagnose_json
from rosbase.imu.diagnosis.plain_text import diagnose_text

__all__ = ["diagnose_frame"]

_MOST_BYTES = 20_000
# Letters and signs, the controls that text has in it, and bytes of other alphabets.
_OF_TEXT = bytes([*b"\t\n\r\x1b", *range(0x20, 0x7F), *range(0x80, 0x100)])
_MOSTLY = 0.8


def diagnose_frame(frame: bytes) -> Cause | None:
    """Return the kind of a frame, if it is a known kind that is not JSON. Never raises.

    Args:
        frame: A frame that was refused as `bad_json`, `not_data` or `not_utf8`.
    """
    frame = frame[:_MOST_BYTES]
    # C ends a text with a zero, which says nothing.
    controls = (frame.rstrip(b"\0") or frame).translate(None, _OF_TEXT)
    try:
        text = frame.decode()
    except UnicodeDecodeError:
        return diagnose_binary(frame) or _damaged(frame)
    found = diagnose_binary(frame) if controls else None
    return found or diagnose_json(text) or diagnose_text(text)


def _damaged(frame: bytes) -> Cause | None:
    """Diagnose text in another encoding, or with bytes damaged on their way."""
    try:
        is_json = isinstance(json.loads(frame.decode("latin-1")), (dict, list))
    except (ValueError, RecursionError):
        is_json = False
    if is_json:
        return Cause("JSON in another encoding, such as Latin-1; the sender must use UTF-8")
    readable = sum(0x20 <= byte < 0x7F for byte in frame)
    if len(frame) > 8 and readable >= _MOSTLY * len(frame):
        return Cause("text in which some bytes are damaged")
    return None
