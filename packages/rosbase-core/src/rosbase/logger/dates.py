"""Dates of log records while a program is recorded or replayed, and who may write to the log.

The dates come from the clock of the program then, so that a replay says the same lines. In a
replay, lines of other threads come from the recording.
"""

import logging
from collections.abc import Callable

__all__ = ["date_at", "date_by", "hear_only", "is_dropped", "set_date"]

_NS_PER_S, _NS_PER_MS = 1_000_000_000, 1_000_000

_dates: list[Callable[[], int]] = []
_heard: list[Callable[[], bool]] = []


def date_by(now_ns: Callable[[], int] | None) -> None:
    """Take the dates of all records from this function; None ends it.

    It is called on any thread that logs, and returns nanoseconds since 1970.
    """
    _dates[:] = [] if now_ns is None else [now_ns]


def hear_only(is_heard: Callable[[], bool] | None) -> None:
    """Drop records of threads for which this function returns false; None ends it."""
    _heard[:] = [] if is_heard is None else [is_heard]


def is_dropped() -> bool:
    """Return whether records of the calling thread are dropped."""
    return any(not is_heard() for is_heard in _heard) if _heard else False


def set_date(record: logging.LogRecord) -> None:
    """Date a record by the function, if there is one."""
    # Another thread may end it meanwhile, so nothing is looked up twice.
    for now_ns in _dates:
        date_at(record, now_ns())


def date_at(record: logging.LogRecord, date_ns: int) -> None:
    """Give a record a date, in nanoseconds since 1970."""
    record.created = date_ns / _NS_PER_S
    record.msecs = date_ns % _NS_PER_S // _NS_PER_MS + 0.0
