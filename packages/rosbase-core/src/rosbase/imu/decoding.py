"""From the bytes of a frame to the payload in it. Never raises."""

import json
import re

from rosbase.imu.rejects import Reject

__all__ = ["decode_payload"]

_decode = json.JSONDecoder().decode

# Boot messages such as `[E][Wire.cpp:513]` begin with a bracket too.
_JSON_START = re.compile(r"\{|\[\s*[-0-9\"\[{\]tfn]")
_ELEMENT = re.compile(r"-?[0-9][0-9.eE+-]*,", re.ASCII)
_BRACKETS = frozenset({"{", "}", "[", "]", "},", "],"})


def decode_payload(frame: bytes) -> object:
    """The object or list in a frame of UTF-8 JSON, or a `Reject` that says why there is none.

    NaN and infinities pass, as they do in Python's JSON: a field that nobody reads may
    hold them. Those that are read are refused later.
    """
    try:
        text = frame.decode()
    except UnicodeDecodeError:
        return Reject("not_utf8")
    try:
        payload = _decode(text)
    except json.JSONDecodeError as error:
        if text.startswith("\ufeff"):
            return decode_payload(text[1:].encode())
        return _reject_text(text.strip(), error)
    except RecursionError:
        return Reject("too_deep")
    except ValueError:
        # What int() says to more than 4,300 digits.
        return Reject("out_of_range")
    if isinstance(payload, (dict, list)):
        return payload
    return Reject("not_data", "a lone value")


def _reject_text(text: str, error: json.JSONDecodeError) -> Reject:
    # The end of a line whose beginning was missed closes more than it opens.
    member = text.startswith('"') and ":" in text and text.count("}") <= text.count("{")
    if text in _BRACKETS or member or _ELEMENT.fullmatch(text):
        return Reject("multi_line")
    if _JSON_START.match(text):
        return Reject("bad_json", f"{error.msg} at column {error.colno}")
    return Reject("not_data")
