"""Text that is nearly JSON: with something around it, or with a habit of another language in it."""

import json
import re
from collections.abc import Callable

from rosbase.imu.diagnosis.cause import Cause, shown

__all__ = ["contains_json", "diagnose_json"]

_NUMBER = r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?"
# A frame may be long and hostile, so each pattern divides a text in one way only: what follows a
# run of characters never begins with one of them.
_MOST_TEXT = 4_000
_MOST_STARTS = 12
_LONGEST_NAME = 60
_BUFFERS = (32, 64, 100, 128, 200, 256, 300, 500, 512, 1000, 1024, 2048, 4096)

_START = re.compile(r"\{\s*[\"'}\w]|\[\s*[-\d\"{\[]")
_TIMESTAMP = re.compile(r"\[?\d{1,2}:\d{2}:\d{2}([.,]\d+)?\]?(\s*(->|>))?\s*")
_ESP_LOG = re.compile(r"(\x1b\[[\d;]*m)?[EWIDV] \(\d+\) ")
_NAME = re.compile(r"[:=]\s?$|^[\w/.-]+\s?$")
_CHECKSUM = re.compile(r"\s?\*\s?[0-9A-Fa-f]{2,8}")
_COMMA = re.compile(r"(:\s*-?\d+),(\d+\s*[,}\]])")
_C_NUMBERS = re.compile(
    r"([:,\[]\s*)[-+]?(?:nan(?:\(\w*\))?|inf(?:inity)?|1\.#\w+)(?=\s*[,}\]])", re.I
)
_OTHER_NUMBER = re.compile(
    r"([:,\[]\s*)"
    r"(?:\+\d[\d.]*|-?\.\d+|-?\d+\.(?=\s*[,}\]])|-?0\d+(?:\.\d+)?|0[xX][0-9a-fA-F]+)"
)
_NO_NUMBER = re.compile(r"([:,\[]\s*)\??(?=[,}\]])")
_FORMAT = re.compile(r"[:,\[]\s*%[-+ #0]*(?:[1-9]\d*)?(?:\.\d+)?l?[fgdeiu]")
_BARE_KEY = re.compile(r"([{,]\s*)([A-Za-z_]\w*)(\s*:)")
_CURLY = re.compile("[\u2018-\u201f]")
_EQUALS = re.compile(r'("\s*)=(?=\s*["\d\-\[{tfn])')
_LAST_COMMA = re.compile(r",(\s*[}\]])")
_NO_COMMA = re.compile(r"([\d\"\]}])(\s+\")")
_PYTHON = re.compile(r"'([^'\"\\]*(?:\\[^\"][^'\"\\]*)*)'|\b(True|False|None)\b")
_AS_JSON = {"True": "true", "False": "false", "None": "null"}


def diagnose_json(text: str) -> Cause | None:
    """Return what keeps a text from being JSON, if it nearly is."""
    text = text[:_MOST_TEXT].strip("\ufeff\0 \t\r\n")
    if not text.startswith("{") and text.endswith("}") and text.count("}") > text.count("{"):
        # As when a reader begins in the middle of a line.
        return Cause("the end of a line whose beginning was missed", is_harmless=True)
    for find in (_cut, _around, _escaped, _habits):
        what = find(text)
        if what:
            return Cause(what)
    return None


def contains_json(text: str) -> bool:
    """Return whether a text is an object or a list in JSON, such as JSON that is encoded twice."""
    return text[:1] in ("{", "[") and _parses(text)


def _parses(text: str) -> bool:
    try:
        return isinstance(json.loads(text), (dict, list))
    except (ValueError, RecursionError):
        return False


def _whole(text: str, start: int) -> tuple[bool, int]:
    """Return whether substantial JSON begins there, and where it ends."""
    try:
        value, end = json.JSONDecoder().raw_decode(text, start)
    except (ValueError, RecursionError):
        return False, 0
    if isinstance(value, list):
        # A lone number in brackets is the time of a line of a log.
        return len(value) > 1 or any(isinstance(one, (dict, list)) for one in value), end
    return isinstance(value, dict) and bool(value), end


def _around(text: str) -> str:
    """Find JSON behind a prefix, before a tail, or several in a row."""
    starts = [found.start() for found in _START.finditer(text)][:_MOST_STARTS]
    for start in starts:
        is_json, end = _whole(text, start)
        if not is_json:
            continue
        before, after = text[:start], text[end:]
        if before.strip().startswith("{"):
            if text[start] == "{" and not after.strip():
                return "one line runs into the next; bytes between them were lost"
            # It is inside of something that is no JSON.
            continue
        if before.strip():
            return _behind(before)
        return _before(after)
    return ""


def _behind(prefix: str) -> str:
    if _ESP_LOG.match(prefix):
        said = "; print it with printf, not with ESP_LOG"
    elif _TIMESTAMP.fullmatch(prefix):
        said = ", a timestamp of whoever logs it; the device must print it alone"
    elif _NAME.search(prefix[-_LONGEST_NAME:]):
        said = ", a name; the device must print it alone"
    else:
        said = "; the device must print it alone"
    return f"JSON behind {shown(prefix)}{said}"


def _before(tail: str) -> str:
    if not tail.strip():
        return ""
    if _CHECKSUM.fullmatch(tail.strip()):
        return f"a checksum behind the JSON, {shown(tail.strip())}: set the parameter checksum"
    if tail.lstrip(" \t\r\n,;").startswith(("{", "[")):
        return "several JSON values in one frame; send each in a line, or a message, of its own"
    return f"more behind the JSON, {shown(tail.strip())}; the device must print it alone"


def _escaped(text: str) -> str:
    """Find JSON in a text, or with the backslashes of one."""
    if text.startswith('"'):
        try:
            inner = json.loads(text)
        except (ValueError, RecursionError):
            return ""
        if isinstance(inner, str) and contains_json(inner):
            return "JSON in a text: it is encoded twice; send the object itself"
    elif '\\"' in text and _parses(text.replace('\\"', '"')):
        return "its quotes are escaped with backslashes; send them plain"
    return ""


def _or_null(match: re.Match[str]) -> str:
    return f"{match[1]}null"


def _in_json(match: re.Match[str]) -> str:
    return _AS_JSON[match[2]] if match[2] else f'"{match[1]}"'


_HABITS: tuple[tuple[re.Pattern[str], str | Callable[[re.Match[str]], str], str], ...] = (
    (_COMMA, r"\1.\2", "numbers with a decimal comma; the device must print a point"),
    (
        _C_NUMBERS,
        _or_null,
        "nan or inf, as C prints them, which is no JSON; the device has divided by zero, or has no"
        " reading",
    ),
    (
        _NO_NUMBER,
        _or_null,
        "a number is missing where the device should print one; does its printf know %f?",
    ),
    (_CURLY, '"', "curly quotes, as a word processor makes them; JSON has straight ones"),
    (_EQUALS, r"\1:", "an equals sign where JSON has a colon"),
    (_PYTHON, _in_json, "a dict as Python prints it, with single quotes; send json.dumps() of it"),
    (_LAST_COMMA, r"\1", "a comma before a closing bracket"),
    (_BARE_KEY, r'\1"\2"\3', "keys without quotes; JSON has them in double quotes"),
    (_OTHER_NUMBER, _or_null, "numbers that JSON does not know, such as +1, .5, 5., 007 or 0x1F"),
    (_NO_COMMA, r"\1,\2", "a comma is missing between two values"),
)
"""Patterns of other languages, with their form in JSON and their names."""


def _habits(text: str) -> str:
    if text[:1] not in ("{", "["):
        return ""
    if _FORMAT.search(text):
        return "a format such as %f where a number should be; the device prints it as it is"
    said: list[str] = []
    for pattern, instead, what in _HABITS:
        changed = pattern.sub(instead, text)
        if changed == text:
            continue
        if _parses(changed):
            return "; ".join([*said, what])
        # More than one of them may be in it, but not in a text that is none of it at all.
        if pattern in (_COMMA, _C_NUMBERS):
            text, said = changed, [*said, what]
    return ""


def _cut(text: str) -> str:
    """Find text that would be JSON if it went on."""
    if not text.startswith("{"):
        return ""
    try:
        json.loads(text)
    except json.JSONDecodeError as error:
        is_open_text = error.msg.startswith("Unterminated string")
        if error.pos < len(text) and not is_open_text:
            return ""
    except (ValueError, RecursionError):
        return ""
    size = len(text.encode())
    for buffer in _BUFFERS:
        if 0 <= buffer - size <= 1:
            return f"cut off after {size} bytes; is a buffer of {buffer} bytes too small?"
    return f"cut off after {size} bytes"
