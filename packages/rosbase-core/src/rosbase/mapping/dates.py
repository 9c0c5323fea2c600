"""When the device says it measured. Only a date counts: an uptime is not one."""

import math
from collections.abc import Callable, Sequence
from datetime import datetime
from typing import TypeAlias

from rosbase.errors import MappingError
from rosbase.mapping.paths import MISSING, Path, follow, variants

__all__ = ["TIME_UNITS", "TimeReader", "compile_time"]

TimeReader: TypeAlias = Callable[[object], int | None]
"""Gives nanoseconds since the Unix epoch, or None if the payload has no usable date."""

TIME_UNITS: dict[str, int] = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}
"""Units of a lone time value, in nanoseconds."""

# A device that counts from its start is somewhere in 1970; a ROS stamp ends in 2038.
_EARLIEST_NS = 946_684_800 * 1_000_000_000
_LATEST_NS = (2**31 - 1) * 1_000_000_000


def compile_time(paths: Sequence[Path], unit: str) -> TimeReader:
    """A reader for the date at `paths`.

    Args:
        paths: One path to a number or an ISO 8601 text with its zone, or two, to the
            seconds and to the nanoseconds.
        unit: The unit of the number, if there is one path.

    Raises:
        MappingError: There are more paths, or the unit is unknown.
    """
    if len(paths) > 2:
        raise MappingError("mapping.time.paths takes one path, or seconds and nanoseconds")
    if len(paths) == 1 and unit not in TIME_UNITS:
        raise MappingError(f"mapping.time.unit is one of {', '.join(TIME_UNITS)}, not {unit!r}")
    units = [TIME_UNITS[unit]] if len(paths) == 1 else [TIME_UNITS["s"], TIME_UNITS["ns"]]
    alternatives = variants(paths, "mapping.time")

    def read(payload: object) -> int | None:
        for steps in alternatives:
            values = [follow(payload, path) for path in steps]
            if MISSING not in values:
                return _date_ns(values, units)
        return None

    return read


def _date_ns(values: Sequence[object], units: Sequence[int]) -> int | None:
    parts = [_to_ns(value, unit_ns) for value, unit_ns in zip(values, units, strict=True)]
    if None in parts or (len(parts) == 2 and not 0 <= (parts[1] or 0) < TIME_UNITS["s"]):
        return None
    total = sum(part for part in parts if part is not None)
    return total if _EARLIEST_NS <= total < _LATEST_NS else None


def _to_ns(value: object, unit_ns: int) -> int | None:
    if isinstance(value, bool):
        return None
    if isinstance(value, int):
        return value * unit_ns
    if isinstance(value, float) and math.isfinite(value):
        return int(value * unit_ns) if abs(value) < 1e18 else None
    if isinstance(value, str):
        return _from_iso(value)
    return None


def _from_iso(text: str) -> int | None:
    try:
        date = datetime.fromisoformat(text)
        # Local time without its zone could be any of forty hours.
        return round(date.timestamp() * 1e6) * 1_000 if date.tzinfo else None
    except (ValueError, OverflowError):
        return None
