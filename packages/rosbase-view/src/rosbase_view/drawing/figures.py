"""Numbers, durations and sizes of few characters, which do not jump about."""

import math

__all__ = ["age", "counted", "duration", "number", "playing_time", "rate", "size", "times"]

_NS = 1_000_000_000


def number(value: float) -> str:
    """Return a number with six digits, with room for its sign: ` 9.80665`."""
    if isinstance(value, int) or not math.isfinite(value):
        return f"{value: }" if isinstance(value, int) else f" {value}"
    return f"{value: .6g}"


def rate(value_hz: float | None) -> str:
    """Return a rate in 8 characters at most, such as `199.8 Hz` or `10.0 kHz`."""
    if value_hz is None:
        return "-"
    if value_hz >= 999.95:
        return f"{value_hz / 1e3:.1f} kHz"
    return f"{value_hz:.1f} Hz"


def age(time_ns: int | None) -> str:
    """Return the time since a message in 5 characters at most: `now`, `3.2 s`, `45 s`, `12 m`.

    Less than a second is `now`: a number that changes all the time tells nobody anything.
    """
    if time_ns is None:
        return "-"
    if time_ns < _NS:
        return "now"
    seconds = time_ns / _NS
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    for limit, divisor, unit in ((120, 1, "s"), (7_200, 60, "m"), (172_800, 3_600, "h")):
        if seconds < limit:
            return f"{int(seconds // divisor)} {unit}"
    return f"{min(int(seconds // 86_400), 999)} d"


def counted(number: int, one: str) -> str:
    """Return a number of things, such as `1 publisher` or `2 publishers`."""
    return f"{number} {one if number == 1 else one + 's'}"


def duration(time_ns: int) -> str:
    """Return a duration, such as `45 s`, `12:03` or `2 d 03:15`."""
    minutes, seconds = divmod(max(0, time_ns) // _NS, 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    if days:
        return f"{days} d {hours:02d}:{minutes:02d}"
    if hours:
        return f"{hours:02d}:{minutes:02d}:{seconds:02d}"
    return f"{minutes}:{seconds:02d}" if minutes else f"{seconds} s"


def playing_time(time_ns: int) -> str:
    """Return a time in a recording, such as `0:05` or `1:02:03`."""
    minutes, seconds = divmod(max(0, time_ns) // _NS, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"


def size(count: int | None) -> str:
    """Return a number of bytes, such as `23.4 MB`."""
    if count is None:
        return "-"
    value = float(count)
    for unit in ("B", "kB", "MB"):
        if value < 1000.0:
            return f"{value:.0f} {unit}" if unit == "B" else f"{value:.1f} {unit}"
        value /= 1000.0
    return f"{value:.1f} GB"


def times(time_ns: float | None) -> str:
    """Return a duration in milliseconds, such as `5.012 ms`."""
    return "-" if time_ns is None else f"{time_ns / 1e6:.3f} ms"
