"""rcl's guess of the type of a value in YAML.

Source: rcl_yaml_param_parser, `get_value` and `parse_value` in parse.c. It guesses as YAML 1.1
does, with numbers read by strtol and strtod, and refuses a list of mixed guesses.
"""

import math
import re
import sys
from collections.abc import Sequence
from typing import Any

from rosbase import Written, WrittenText

__all__ = ["is_guess_of", "is_mixed"]

_TRUE, _FALSE = (
    frozenset(form for word in words for form in (word, word.capitalize(), word.upper()))
    for words in (("y", "yes", "true", "on"), ("n", "no", "false", "off"))
)
_INTEGER = re.compile(r"[-+]?(0[xX][0-9a-fA-F]+|0[0-7]*|[1-9]\d*)", re.ASCII)
_DOTTED = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_DOUBLE = re.compile(
    r"[-+]?((\d+\.?\d*|\.\d+)(e[-+]?\d+)?|inf(inity)?|nan)", re.ASCII | re.IGNORECASE
)
_HEX_DOUBLE = re.compile(
    r"[-+]?0[xX]([0-9a-f]+\.?[0-9a-f]*|\.[0-9a-f]+)(p[-+]?\d+)?", re.ASCII | re.IGNORECASE
)
_INT64 = 2**63
# Longer texts are no numbers that mean anything, and Python refuses to convert some.
_LONGEST = 400


def is_guess_of(value: Any, written: Written) -> bool:
    """Return whether rcl makes that value of the text; None is its value for an empty list."""
    if isinstance(written, WrittenText):
        # As text, because no NaN is equal to another.
        return repr(_guess(written)) == repr(value)
    if not written:
        return value is None
    guesses = [item.text for item in written] if is_mixed(written) else [*map(_guess, written)]
    return repr(guesses) == repr(value)


def is_mixed(items: Sequence[WrittenText]) -> bool:
    """Return whether rcl refuses a list, because it guesses different types for its items."""
    return len({type(_guess(item)) for item in items}) > 1


def _guess(written: WrittenText) -> bool | int | float | str:
    text = written.text
    if written.is_quoted or len(text) > _LONGEST:
        return text
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    if _INTEGER.fullmatch(text):
        number = _integer(text)
        if -_INT64 <= number < _INT64:
            return number
    if _DOTTED.fullmatch(text):
        return float(text.replace(".", ""))
    if _DOUBLE.fullmatch(text) or _HEX_DOUBLE.fullmatch(text):
        double = _double(text)
        return text if double is None else double
    return text


def _double(text: str) -> float | None:
    """Return the number, as strtod reads it; None for one that it reports as too large or small."""
    if "n" in text.lower():
        return float(text)
    try:
        double = float.fromhex(text) if "x" in text.lower() else float(text)
    except OverflowError:
        return None
    digits = re.split("[eEpP]", text)[0].lower().replace("0x", "")
    is_small = abs(double) < sys.float_info.min and digits.strip("+-0.") != ""
    return None if is_small or math.isinf(double) else double


def _integer(text: str) -> int:
    digits = text.lstrip("+-")
    is_octal = digits.startswith("0") and not digits.lower().startswith("0x")
    magnitude = int(digits, 8) if is_octal else int(digits, 0)
    return -magnitude if text.startswith("-") else magnitude
