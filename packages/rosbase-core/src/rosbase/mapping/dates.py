"""Convert the dates in payloads to nanoseconds since 1970. An uptime is not a date."""

import json
import math
from collections.abc import Sequence
from datetime import datetime

from rosbase.mapping.following import Missing
from rosbase.mapping.reals import JSON_NUMBER
from rosbase.mapping.rejects import Reject

__all__ = ["TIME_UNITS", "date_ns", "is_date"]

TIME_UNITS: dict[str, int] = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}
"""Units of a single time value, in nanoseconds."""

# A device that counts from its start is somewhere in the 1970s. Whether a date from 1980 on, where
# GPS begins, can be right is for those to say that know the time.
_EARLIEST_NS = 315_532_800 * 1_000_000_000
_LATEST_NS = 253_402_300_800 * 1_000_000_000


def is_date(total_ns: int) -> bool:
    """Return whether nanoseconds since 1970 are a possible date of a device."""
    return _EARLIEST_NS <= total_ns < _LATEST_NS


def date_ns(
    values: Sequence[object], units: Sequence[int], *, numeric_strings: bool
) -> int | Reject:
    """Return the date that consists of the values, or the reason why it is unusable.

    Args:
        values: A number or an ISO 8601 text with its zone; or seconds and nanoseconds.
        units: The unit of each value, in nanoseconds.
        numeric_strings: Whether a text that is a JSON number counts as one.
    """
    total = part = 0
    for value, unit_ns in zip(values, units, strict=True):
        read = _to_ns(value, unit_ns, numeric_strings)
        if isinstance(read, Reject):
            return read
        part = read
        total += part
    if len(values) == 2 and not 0 <= part < TIME_UNITS["s"]:
        return _unusable("the nanoseconds are more than a second, or negative")
    if is_date(total):
        return total
    if total < 0:
        return _unusable("a date before 1970")
    if total < _EARLIEST_NS:
        return _unusable(f"{total / 1e9:.6g} s after 1970 is an uptime, not a date")
    return _unusable("a date after the year 9999; is mapping.time.unit right?")


def _unusable(why: str) -> Reject:
    return Reject("time_unusable", why)


def _to_ns(value: object, unit_ns: int, numeric_strings: bool) -> int | Reject:
    if isinstance(value, str):
        is_number = JSON_NUMBER.fullmatch(value.strip()) is not None
        if is_number and not numeric_strings:
            return _unusable(f"{_shown(value)} is text; set mapping.numeric_strings")
        if not is_number:
            return _from_iso(value)
        value = _number(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return value * unit_ns
    if isinstance(value, float) and math.isfinite(value) and abs(value) < 1e18:
        return int(value * unit_ns)
    return _unusable(f"{_shown(value)} is no date")


def _number(text: str) -> object:
    try:
        return json.loads(text)
    except ValueError:
        # What int() says to more than 4,300 digits.
        return math.inf


def _from_iso(text: str) -> int | Reject:
    try:
        date = datetime.fromisoformat(text)
        seconds = date.timestamp()
    except (ValueError, OverflowError):
        return _unusable(f"{_shown(text)} is no date")
    if date.tzinfo is None:
        # It could be any of forty hours.
        return _unusable(f"{_shown(text)} has no time zone")
    return round(seconds * 1e6) * 1_000


def _shown(value: object) -> str:
    if isinstance(value, Missing):
        return "nothing"
    text = repr(value) if not isinstance(value, int) or abs(value) < 1e18 else "a huge number"
    return text if len(text) <= 40 else f"{text[:37]}..."
