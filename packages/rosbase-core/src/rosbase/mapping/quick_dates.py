"""Read dates quickly in the usual case, and carefully otherwise."""

from collections.abc import Callable
from operator import itemgetter
from typing import Any, TypeAlias

from rosbase.mapping.dates import is_date, to_whole_ns
from rosbase.mapping.paths import Steps
from rosbase.mapping.times import Date, Dates

__all__ = ["DateReader", "compile_date"]

DateReader: TypeAlias = Callable[[Any], Date]
"""Function from a payload to its date."""

_NS_PER_S = 1_000_000_000


def compile_date(dates: Dates) -> DateReader:
    """Return a reader of the date of a payload with one sample.

    Usually the first alternative leads to whole seconds and nanoseconds, or to one number.
    `Dates` reads all other payloads.
    """
    ways = dates.first_ways
    parents = {steps[:-1] for steps in ways}
    if len(parents) > 1 or not all(isinstance(s, (str, int)) for steps in ways for s in steps):
        return dates.date
    parent, keys = parents.pop(), [steps[-1] for steps in ways]
    if len(keys) == 1:
        return _number(parent, keys[0], dates.units[0], dates.date)
    return _seconds(parent, itemgetter(*keys), dates.date)


def _seconds(parent: Steps, take: Callable[[Any], Any], careful: DateReader) -> DateReader:
    steps: tuple[Any, ...] = parent

    def read(payload: Any) -> Date:
        try:
            place = payload
            for step in steps:
                place = place[step]
            seconds, rest = take(place)
        except (KeyError, IndexError, TypeError, ValueError):
            return careful(payload)
        if seconds.__class__ is int and rest.__class__ is int and 0 <= rest < _NS_PER_S:
            total = seconds * _NS_PER_S + rest
            if is_date(total):
                return total
        return careful(payload)

    return read


def _number(parent: Steps, key: Any, unit_ns: int, careful: DateReader) -> DateReader:
    steps: tuple[Any, ...] = (*parent, key)

    def read(payload: Any) -> Date:
        try:
            value = payload
            for step in steps:
                value = value[step]
        except (KeyError, IndexError, TypeError):
            return careful(payload)
        if value.__class__ is int or (value.__class__ is float and abs(value) < 1e18):
            total = to_whole_ns(value, unit_ns)
            if is_date(total):
                return total
        return careful(payload)

    return read
