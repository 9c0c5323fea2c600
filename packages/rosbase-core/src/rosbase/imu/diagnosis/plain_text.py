"""Text that is not JSON at all: rows of numbers, sentences, and digits for bytes."""

import base64
import binascii
import re

from rosbase.imu.diagnosis.cause import Cause, shown
from rosbase.imu.diagnosis.sayings import diagnose_saying

__all__ = ["diagnose_text"]

# It begins as it goes on, and a hostile one is not read to its end. Each pattern divides a text in
# one way only; with two for each gap, a line of fifty numbers would take years.
_MOST_TEXT = 396
_N = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
_GAP = r"(?:\s{1,6}|\s?[,;]\s{0,4})"
_ROW = re.compile(rf"\s?{_N}(?:{_GAP}{_N})+[,;.]?\s?")
_LABEL = r"[A-Za-z_][\w.]*\s?[:=]\s?"
_LABELLED = re.compile(rf"\s?{_LABEL}{_N}(?:{_GAP}{_LABEL}{_N})*[,;.]?\s?")
_TAGGED = re.compile(rf"[#!@$]?([A-Za-z]\w*)[=:,]\s?{_N}(?:{_GAP}{_N})+[,;.]?\s?")
_NMEA = re.compile(r"[$!]([A-Z]{2,5}[A-Z0-9]{0,3}),[^*]*(?:\*[0-9A-Fa-f]{2})?\s*")
_HEX = re.compile(r"(?:[0-9a-fA-F]{2}[ :]?){6,}")
_BASE64 = re.compile(r"[A-Za-z0-9+/]{16,}={0,2}")
_COLOUR = re.compile(r"\x1b\[[\d;]*[A-Za-z]")
_JSON_STARTS = (b'{"', b"[{", b"[[")
_GPS_TALKERS = ("GP", "GN", "GL", "GA", "GB", "BD", "QZ")


def diagnose_text(text: str) -> Cause | None:
    """Return the kind of a text, if it is a known kind that is not JSON."""
    text = _COLOUR.sub("", text[:_MOST_TEXT]).strip("\0\r\n")
    known = diagnose_saying(text)
    if known is not None:
        return known
    said = _sentence(text) or _numbers(text) or _encoded(text)
    return Cause(said) if said else None


def _sentence(text: str) -> str:
    found = _NMEA.fullmatch(text)
    if not found:
        return ""
    name = found[1]
    if name.startswith("VN"):
        return f"{name}, a sentence of a VectorNav sensor; this reader takes JSON"
    receiver = ", as of a GPS receiver" if name.startswith(_GPS_TALKERS) else ""
    return f"{name}, a sentence of NMEA 0183{receiver}; this reader takes JSON"


def _numbers(text: str) -> str:
    if _ROW.fullmatch(text):
        count = len(re.findall(_N, text))
        return f"{count} numbers in a row (CSV); the device must send them as JSON"
    if found := _TAGGED.fullmatch(text):
        return f"numbers behind the tag {shown(found[1])}; the device must send them as JSON"
    if _LABELLED.fullmatch(text):
        return "numbers with labels, as for a plotter; the device must send them as JSON"
    return ""


def _encoded(text: str) -> str:
    if _HEX.fullmatch(text):
        inner = bytes.fromhex(re.sub("[ :]", "", text))
        is_json = inner.startswith(_JSON_STARTS)
        return f"{'JSON' if is_json else 'bytes'} in hexadecimal digits; send the text itself"
    if _BASE64.fullmatch(text):
        try:
            inner = base64.b64decode(text[: len(text) // 4 * 4])
        except binascii.Error:
            return ""
        if inner.startswith(_JSON_STARTS):
            return "JSON in base64; send the text itself"
    return ""
