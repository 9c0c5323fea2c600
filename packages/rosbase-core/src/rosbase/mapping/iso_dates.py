"""Read dates that are texts, as ISO 8601 and RFC 3339 allow them."""

import re
from datetime import UTC, datetime, timedelta

__all__ = ["iso_ns"]

_MIDNIGHT = re.compile(r"(?<=[T ])24(?=:?00(:?00([.,]0+)?)?(Z|[-+]|$))")
_LEAP = re.compile(r"(?<=[T ])(\d\d:?\d\d:?)60(?=[.,Z+-]|$)", re.ASCII)
_MINUS = str.maketrans("\u2212", "-")


def iso_ns(text: str) -> int:
    """Return nanoseconds since 1970.

    Raises:
        ValueError: It is no date, or has no time zone; the message says which.
    """
    # Lower case is valid; Python's parser takes upper case only.
    plain = text.strip().upper().translate(_MINUS)
    # Python's parser takes neither the midnight at the end of a day nor a leap second.
    plain, midnights = _MIDNIGHT.subn("00", plain)
    plain, leaps = _LEAP.subn(r"\g<1>59", plain)
    try:
        date = datetime.fromisoformat(plain)
    except ValueError:
        raise ValueError("is no date") from None
    if date.tzinfo is None:
        # It could be any of forty hours.
        raise ValueError("has no time zone")
    if leaps and not _ends_a_month(date):
        raise ValueError("is no leap second, which only ends a month in UTC")
    later_s = 86_400 * midnights + leaps
    return round((date.timestamp() + later_s) * 1e6) * 1_000


def _ends_a_month(date: datetime) -> bool:
    try:
        after = date.astimezone(UTC) + timedelta(seconds=1)
    except OverflowError:
        return False
    return (after.day, after.hour, after.minute, after.second) == (1, 0, 0, 0)
