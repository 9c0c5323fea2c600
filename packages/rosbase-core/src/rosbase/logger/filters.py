"""The filters `once`, `skip_first` and `throttle_duration_sec` of rclpy, for each call site."""

import threading
from typing import Any, TypedDict

from rosbase.clock import Clock
from rosbase.logger.call_sites import CallSite

__all__ = ["FILTERS", "Filters", "LogOptions", "make_room"]

_NS_PER_S = 1_000_000_000
# From here on the oldest are forgotten. A program has fewer call sites, unless it makes code.
_MANY_KEYS = 1000

FILTERS = frozenset(("once", "skip_first", "throttle_duration_sec", "throttle_time_source_type"))
"""Options that are filters."""


class LogOptions(TypedDict, total=False):
    """Keyword arguments of each level's method."""

    once: bool
    """Log only the first call from this place."""
    skip_first: bool
    """Leave out the first call from this place."""
    throttle_duration_sec: float
    """Minimum seconds between two logged calls from this place."""
    throttle_time_source_type: Any
    """Clock of rosbase or rclpy to throttle by; by default the monotonic clock."""
    exc_info: Any
    """As in `logging`: an exception, its `sys.exc_info()`, or true for the current one."""
    stack_info: bool
    """As in `logging`: whether to show the call stack below the line."""
    stacklevel: int
    """As in `logging`: which caller counts as the place; 1 is the caller of the method."""
    extra: dict[str, object]
    """As in `logging`: attributes for the record, for the application's own formatters."""


class Filters:
    """Remembers the logged calls of each place. A filter counts only calls of enabled levels."""

    def __init__(self) -> None:
        """Start with nothing logged."""
        self._lock = threading.Lock()
        self._logged: dict[Any, None] = {}
        self._skipped: dict[Any, None] = {}
        self._last_ns: dict[Any, int] = {}

    def pass_on(self, site: CallSite, level: int, options: LogOptions, clock: Clock) -> bool:
        """Return whether a call is logged. The order is rclpy's: throttle, skip_first, once.

        Raises:
            TypeError: There is a clock to throttle by, and no duration.
            ValueError: The clock is invalid.
        """
        key, duration_s = (site, level), options.get("throttle_duration_sec")
        source = options.get("throttle_time_source_type")
        if source is not None and duration_s is None:
            raise TypeError("throttle_time_source_type needs throttle_duration_sec")
        now_ns = _read(source) if source is not None else clock.monotonic_ns()
        with self._lock:
            if duration_s and not self._is_due(key, duration_s, now_ns):
                return False
            if options.get("skip_first") and _is_first(self._skipped, key):
                return False
            return not options.get("once") or _is_first(self._logged, key)

    def reset(self) -> None:
        """Forget every call."""
        with self._lock:
            self._logged.clear()
            self._skipped.clear()
            self._last_ns.clear()

    def _is_due(self, key: Any, duration_s: float, now_ns: int) -> bool:
        last_ns = self._last_ns.get(key)
        if last_ns is not None and 0 <= now_ns - last_ns < duration_s * _NS_PER_S:
            return False
        make_room(self._last_ns)
        self._last_ns[key] = now_ns
        return True


def make_room(known: dict[Any, Any]) -> None:
    """Forget the oldest keys if there are too many."""
    while len(known) >= _MANY_KEYS:
        del known[next(iter(known))]


def _is_first(known: dict[Any, None], key: Any) -> bool:
    if key in known:
        return False
    make_room(known)
    known[key] = None
    return True


def _read(source: Any) -> int:
    try:
        return int(source.now().nanoseconds)
    except AttributeError:
        raise ValueError(f"throttle_time_source_type is {source!r}, not a clock") from None
