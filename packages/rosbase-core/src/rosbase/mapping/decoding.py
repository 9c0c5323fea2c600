"""Decode the bytes of a frame to a payload. Never raises."""

import json
import re
from collections.abc import Callable

from rosbase.mapping.rejects import Reject
from rosbase.mapping.repeats import OF_NUMBERS, known_forms, repeated_key

try:
    # The extra `fast`. It refuses some texts that Python's decoder takes, and reads the rest alike.
    from msgspec.json import Decoder
except ImportError:
    _decode_quickly: Callable[[bytes], object] | None = None
else:
    _decode_quickly = Decoder().decode

__all__ = ["REPEATED", "decode_payload"]

REPEATED = "the key"
"""Beginning of a refusal's detail when an object has a key twice."""

_decode = json.JSONDecoder().decode

_A_LONE_VALUE = Reject("not_data", "a lone value")

# Boot messages such as `[E][Wire.cpp:513]` begin with a bracket too.
_JSON_START = re.compile(r"\{|\[\s*[-0-9\"\[{\]tfn]")
_ELEMENT = re.compile(r"-?[0-9][0-9.eE+-]*,", re.ASCII)
_BRACKETS = frozenset({"{", "}", "[", "]", "},", "],"})


def decode_payload(frame: bytes) -> object:
    """Return the object or list in a frame of UTF-8 JSON, or the reason to refuse the frame.

    NaN and infinities pass, as in Python's JSON: a field that the mapping does not read may
    hold them. The quantities refuse them.
    """
    if _decode_quickly is not None:
        try:
            payload = _decode_quickly(frame)
        except Exception:
            # Such as NaN. The careful way decides.
            pass
        else:
            is_known = frame.translate(None, OF_NUMBERS) in known_forms
            return payload if is_known else _checked(frame, payload)
    return _decode_carefully(frame)


def _checked(frame: bytes, payload: object) -> object:
    if not isinstance(payload, (dict, list)):
        return _A_LONE_VALUE
    try:
        key = repeated_key(frame, payload)
    except RecursionError:
        return Reject("too_deep")
    return payload if key is None else Reject("bad_json", f"{REPEATED} {key[:40]!r} stands twice")


def _decode_carefully(frame: bytes) -> object:
    try:
        text = frame.decode()
    except UnicodeDecodeError:
        return Reject("not_utf8")
    try:
        payload = _decode(text)
    except json.JSONDecodeError as error:
        # A message without a line end may begin with a byte order mark and end with C's NUL.
        plain = text.removeprefix("\ufeff").rstrip("\0")
        if plain != text:
            return _decode_carefully(plain.encode())
        return _reject_text(text.strip(), error)
    except RecursionError:
        return Reject("too_deep")
    except ValueError:
        # int() raises it for more than 4,300 digits.
        return Reject("out_of_range")
    return _checked(frame, payload)


def _reject_text(text: str, error: json.JSONDecodeError) -> Reject:
    # A line without its beginning closes more brackets than it opens.
    member = text.startswith('"') and ":" in text and text.count("}") <= text.count("{")
    if text in _BRACKETS or member or _ELEMENT.fullmatch(text):
        return Reject("multi_line")
    if _JSON_START.match(text):
        return Reject("bad_json", f"{error.msg} at column {error.colno}")
    return Reject("not_data")
