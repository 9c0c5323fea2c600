"""The time between the samples of one message: a constant, or a value in the payload."""

import math
from collections.abc import Callable
from typing import TypeAlias

from rosbase.errors import MappingError
from rosbase.mapping.dates import TIME_UNITS
from rosbase.mapping.following import MISSING, follow
from rosbase.mapping.path_text import parse_path
from rosbase.mapping.paths import EACH, Path
from rosbase.mapping.reals import JSON_NUMBER, to_float
from rosbase.mapping.rejects import Reject

__all__ = ["IntervalReader", "compile_interval", "interval_path"]

IntervalReader: TypeAlias = Callable[[object], int | None]
"""Function from a payload to nanoseconds, or None if the payload has no usable interval."""

_RATE = "Hz"
_LONGEST_NS = 60 * TIME_UNITS["s"]
_HOW = "write a number or a path and its unit, such as '5 ms', '200 Hz' or 'rate Hz'"


def compile_interval(text: str, *, numeric_strings: bool) -> IntervalReader:
    """Return a reader of the interval that `text` describes.

    Raises:
        MappingError: It describes no interval.
    """
    what, unit = _split(text)
    if JSON_NUMBER.fullmatch(what):
        constant = _to_ns(float(what), unit)
        if constant is None:
            raise MappingError(f"mapping.time.interval is not {text!r}: it is up to a minute")
        return lambda payload: constant
    path = interval_path(text, numeric_strings=numeric_strings)
    if any(EACH in way.steps or way.sign < 0 for way in path):
        raise MappingError("the path of mapping.time.interval has no [*] and no minus")

    def read(payload: object) -> int | None:
        number = to_float(_find(payload, path), numeric_strings=numeric_strings)
        return None if isinstance(number, Reject) else _to_ns(number, unit)

    return read


def interval_path(text: str, *, numeric_strings: bool = False) -> Path:
    """Return the path to the interval; empty if it is a constant, or there is none.

    Raises:
        MappingError: The text describes no interval.
    """
    what, _ = _split(text) if text else ("", "")
    if not what or JSON_NUMBER.fullmatch(what):
        return ()
    return parse_path(what, numeric_strings=numeric_strings)


def _split(text: str) -> tuple[str, str]:
    """Return the number or path, and the unit."""
    what, _, unit = text.strip().rpartition(" ")
    if unit not in (*TIME_UNITS, _RATE) or not what.strip():
        raise MappingError(f"mapping.time.interval is not {text!r}: {_HOW}")
    return what.strip(), unit


def _find(payload: object, path: Path) -> object:
    for way in path:
        found = follow(payload, way.steps)
        if found is not MISSING and found is not None:
            return found
    return MISSING


def _to_ns(number: float, unit: str) -> int | None:
    if number <= 0.0:
        return None
    interval = TIME_UNITS["s"] / number if unit == _RATE else number * TIME_UNITS[unit]
    return round(interval) if math.isfinite(interval) and 1 <= interval <= _LONGEST_NS else None
