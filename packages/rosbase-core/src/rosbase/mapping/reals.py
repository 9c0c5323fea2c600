"""Convert numbers of payloads to floats, with a reason for every other value."""

import json
import math
import re

from rosbase.mapping.rejects import Reject

__all__ = ["JSON_NUMBER", "number_in", "to_float"]

JSON_NUMBER = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?", re.ASCII)
"""A number as in JSON. Python's float() also takes 'nan', '1_0' and Arabic digits."""


def to_float(value: object, *, numeric_strings: bool) -> float | Reject:
    """Return the value as a finite float, or the reason why it is none.

    Args:
        value: Any value of JSON.
        numeric_strings: Whether a text that is a JSON number counts as one.
    """
    if isinstance(value, str) and numeric_strings and JSON_NUMBER.fullmatch(value.strip()):
        value = float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return Reject("wrong_type", _kind(value))
    try:
        number = float(value)
    except OverflowError:
        return Reject("out_of_range", "an integer beyond any double")
    return number if math.isfinite(number) else Reject("non_finite", str(number))


def number_in(text: str) -> int | float | None:
    """Return the JSON number that a text consists of, with every digit; None if it is none."""
    text = text.strip()
    if not JSON_NUMBER.fullmatch(text):
        return None
    try:
        number: int | float = json.loads(text)
    except ValueError:
        # int() raises it for more than 4,300 digits.
        return -math.inf if text.startswith("-") else math.inf
    return number


def _kind(value: object) -> str:
    names = {type(None): "null", bool: "true or false", str: "text", list: "a list"}
    return names.get(type(value), "an object")
