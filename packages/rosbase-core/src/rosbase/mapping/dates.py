"""Convert the dates in payloads to nanoseconds since 1970. An uptime is not a date."""

from collections.abc import Sequence

from rosbase.mapping.following import Missing
from rosbase.mapping.iso_dates import iso_ns
from rosbase.mapping.reals import number_in
from rosbase.mapping.rejects import Reject

__all__ = ["TIME_UNITS", "date_ns", "is_date", "to_whole_ns"]

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
    parts: list[int] = []
    for value, unit_ns in zip(values, units, strict=True):
        read = _to_ns(value, unit_ns, numeric_strings)
        if isinstance(read, Reject):
            return read
        parts.append(read)
    if len(parts) == 2:
        wrong = _odd_pair(values[1], *parts)
        if wrong:
            return _unusable(wrong)
    total = sum(parts)
    if is_date(total):
        return total
    if total < 0:
        return _unusable("a date before 1970")
    if total < _EARLIEST_NS:
        return _unusable(f"{total / 1e9:.6g} s after 1970 is an uptime, not a date")
    return _unusable("a date after the year 9999; is mapping.time.unit right?")


def _odd_pair(rest: object, seconds_ns: int, rest_ns: int) -> str:
    """Return why two parts are not whole seconds and the nanoseconds after them."""
    if seconds_ns % TIME_UNITS["s"]:
        return "the seconds have a fraction beside the nanoseconds; read one of them"
    if isinstance(rest, str) and number_in(rest) is None:
        return f"{_shown(rest)} is no number of nanoseconds"
    is_part = 0 <= rest_ns < TIME_UNITS["s"]
    return "" if is_part else "the nanoseconds are more than a second, or negative"


def _unusable(why: str) -> Reject:
    return Reject("time_unusable", why)


def _to_ns(value: object, unit_ns: int, numeric_strings: bool) -> int | Reject:
    number: object = value
    if isinstance(value, str):
        number = number_in(value)
        if number is None:
            return _from_iso(value)
        if not numeric_strings:
            return _unusable(f"{_shown(value)} is text; set mapping.numeric_strings")
    if isinstance(number, int) and not isinstance(number, bool):
        return number * unit_ns
    if isinstance(number, float) and abs(number) < 1e18:
        return to_whole_ns(number, unit_ns)
    return _unusable(f"{_shown(value)} is no date")


def to_whole_ns(number: float, unit_ns: int) -> int:
    """Return a finite number of units in nanoseconds, without a rounding if it is whole."""
    whole = int(number)
    return whole * unit_ns if whole == number else int(number * unit_ns)


def _from_iso(text: str) -> int | Reject:
    try:
        return iso_ns(text)
    except ValueError as error:
        return _unusable(f"{_shown(text)} {error}")


def _shown(value: object) -> str:
    if isinstance(value, Missing):
        return "nothing"
    text = repr(value) if not isinstance(value, int) or abs(value) < 1e18 else "a huge number"
    return text if len(text) <= 40 else f"{text[:37]}..."
