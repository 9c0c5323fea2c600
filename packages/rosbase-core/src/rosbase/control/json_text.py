"""JSON to and from text, by the C part of Python's `json` alone.

`json` itself imports regular expressions, which take half as long as Python's whole start: more
than all the rest of a command that asks a running program. A Python without that part has `json`.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

try:
    import _json

    _fast: Any = _json
except ImportError:
    _fast = None

__all__ = ["from_json", "to_json"]

_BLANKS = " \t\n\r"


def to_json(value: Any) -> str:
    """Return a value as JSON: one line of ASCII, without blanks.

    Raises:
        TypeError: There is something in it that JSON has not.
        ValueError: There is a NaN, an infinite number or a loop in it.
        RecursionError: It is nested too deeply.
    """
    if _fast is None:
        return _encode_slowly(value)
    # What it refuses, how it writes texts, its separators; neither sorted keys nor NaN.
    rules: Any = {}, _refuse, _fast.encode_basestring_ascii, None, ":", ",", False, False, False
    encode = _fast.make_encoder(*rules)
    return "".join(encode(value, 0))


def from_json(text: str) -> Any:
    """Return the value in a text.

    Raises:
        ValueError: It is no JSON.
        RecursionError: It is nested too deeply.
    """
    if _fast is None:
        return _decode_slowly(text)
    text = text.strip(_BLANKS)
    try:
        value, end = _scan(text, 0)
    except StopIteration:
        raise ValueError("no value") from None
    if end != len(text):
        raise ValueError("something follows the value")
    return value


class _Rules:
    """How the scanner reads: as `json.loads`, without NaN and Infinity."""

    strict = True
    object_hook = None
    object_pairs_hook = None
    parse_float = float
    parse_int = int

    @staticmethod
    def parse_constant(name: str) -> None:
        """Refuse NaN and Infinity.

        Raises:
            ValueError: Always.
        """
        raise ValueError(f"{name} is no number of JSON")


def _refuse(value: object) -> None:
    raise TypeError(f"{type(value).__name__} has no form in JSON")


def _encode_slowly(value: Any) -> str:
    import json

    return json.dumps(value, separators=(",", ":"), allow_nan=False)


def _decode_slowly(text: str) -> Any:
    import json

    return json.loads(text, parse_constant=_Rules.parse_constant)


_scan: Any = None if _fast is None else _fast.make_scanner(_Rules())
