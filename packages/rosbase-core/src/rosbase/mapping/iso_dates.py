"""Read dates that are texts, as ISO 8601 and RFC 3339 allow them.

Python's own parser takes more or less of them with each version.
"""

import re
from datetime import date

__all__ = ["iso_ns"]

_ISO = re.compile(
    r"""
    (?P<year>\d{4}) (?P<dash>-?)
    (?:
        (?P<month>\d\d) (?P=dash) (?P<day>\d\d)
        | W (?P<week>\d\d) (?: (?P=dash) (?P<weekday>\d) )?
    )
    (?:
        \D (?P<hour>\d\d)
        (?:
            (?P<colon>:?) (?P<minute>\d\d)
            (?: (?P=colon) (?P<second>\d\d) (?: [.,] (?P<fraction>\d+) )? )?
        )?
        (?P<zone> Z | (?P<sign>[-+]) (?P<hours>[01]\d|2[0-3]) (?: :? (?P<minutes>[0-5]\d) )? )?
    )?
    """,
    re.ASCII | re.VERBOSE,
)
_MINUS = str.maketrans("\u2212", "-")
_DAY_S, _HOUR_S, _MINUTE_S = 86_400, 3_600, 60
_EPOCH_DAY = date(1970, 1, 1).toordinal()


def iso_ns(text: str) -> int:
    """Return nanoseconds since 1970; digits behind the microseconds do not count.

    Raises:
        ValueError: It is no date, or has no time zone; the message says which.
    """
    # Lower case is valid.
    found = _ISO.fullmatch(text.strip().upper().translate(_MINUS))
    if found is None:
        raise ValueError("is no date")
    try:
        day = _day(found)
    except ValueError:
        raise ValueError("is no date") from None
    hour, minute, second = (int(found[name] or 0) for name in ("hour", "minute", "second"))
    micros = int((found["fraction"] or "")[:6].ljust(6, "0"))
    # A day ends at midnight, which is 24:00 too, and a minute with a leap second at 60.
    is_midnight = hour == 24 and not (minute or second or micros)
    if not ((hour < 24 or is_midnight) and minute < 60 and second <= 60):
        raise ValueError("is no date")
    if found["zone"] is None:
        # It could be any of forty hours.
        raise ValueError("has no time zone")
    day_s = hour * _HOUR_S + minute * _MINUTE_S + second - _offset_s(found)
    total_s = (day.toordinal() - _EPOCH_DAY) * _DAY_S + day_s
    if second == 60 and not _begins_a_month(total_s):
        raise ValueError("is no leap second, which only ends a month in UTC")
    return (total_s * 1_000_000 + micros) * 1_000


def _day(found: re.Match[str]) -> date:
    if found["week"]:
        weekday = int(found["weekday"] or 1)
        return date.fromisocalendar(int(found["year"]), int(found["week"]), weekday)
    return date(int(found["year"]), int(found["month"]), int(found["day"]))


def _offset_s(found: re.Match[str]) -> int:
    """Return how far the clocks of its time zone are ahead of UTC."""
    offset_s = int(found["hours"] or 0) * _HOUR_S + int(found["minutes"] or 0) * _MINUTE_S
    return -offset_s if found["sign"] == "-" else offset_s


def _begins_a_month(total_s: int) -> bool:
    days, rest_s = divmod(total_s, _DAY_S)
    try:
        return rest_s == 0 and date.fromordinal(_EPOCH_DAY + days).day == 1
    except (ValueError, OverflowError):
        # Beyond the year 9999, or before the year 1.
        return False
