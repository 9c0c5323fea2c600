"""Read the dates of samples."""

from collections.abc import Sequence
from typing import TypeAlias

from rosbase.mapping.dates import TIME_UNITS, date_ns, is_date
from rosbase.mapping.description import TimeMapping
from rosbase.mapping.following import MISSING, follow
from rosbase.mapping.known_keys import Keys, KnownKeys, is_left_out
from rosbase.mapping.paths import EACH, Steps, show_steps
from rosbase.mapping.rejects import Reject
from rosbase.mapping.surplus import elements_at
from rosbase.mapping.ways import time_ways

__all__ = ["Date", "Dates"]

Date: TypeAlias = int | Reject
"""Nanoseconds since 1970, or the reason why the date is unusable."""


class Dates:
    """Reads the dates of one message."""

    def __init__(
        self, time: TimeMapping, known: KnownKeys, *, numeric_strings: bool, absent_is_zero: bool
    ) -> None:
        """Prepare to read dates. `check_time` must have passed."""
        found = time_ways(time, numeric_strings=numeric_strings)
        self._alternatives = [tuple(way.steps for way in ways) for ways in found]
        self._keys = {ways: [known.along(steps) for steps in ways] for ways in self._alternatives}
        """The keys known in the objects on each way, by alternative."""
        self.first_ways = self._alternatives[0]
        """The ways of the first alternative."""
        is_lone = len(time.paths) == 1
        self.units = [TIME_UNITS[time.unit]] if is_lone else [TIME_UNITS["s"], TIME_UNITS["ns"]]
        """The unit of each part of a date, in nanoseconds."""
        self._has_each = EACH in self.first_ways[0]
        self._numeric_strings = numeric_strings
        self._absent_is_zero = absent_is_zero
        said = show_steps(self.first_ways[0])
        self._nothing = Reject("time_unusable", f"nothing at {said}")

    def date(self, payload: object) -> Date:
        """Return the date of a payload with one sample."""
        for ways in self._alternatives:
            date = self._judge([payload] * len(ways), ways, self._keys[ways])
            if date is not None:
                return date
        return self._nothing

    def dates(self, payload: object, count: int, interval_ns: int | None) -> list[Date]:
        """Return the dates of the samples of a payload.

        Args:
            payload: A payload with a date for each sample, or for the first.
            count: The number of samples.
            interval_ns: The time between two samples, if it is known.
        """
        if not self._has_each:
            return self._from_start(self.date(payload), count, interval_ns)
        for ways in self._alternatives:
            dates = self._each(payload, ways, count)
            if dates:
                return dates
        return [self._nothing] * count

    def _from_start(self, start: Date, count: int, interval_ns: int | None) -> list[Date]:
        if isinstance(start, Reject):
            return [start] * count
        if interval_ns is None:
            return [Reject("time_unusable", "nothing usable at mapping.time.interval")] * count
        dates = [start + at * interval_ns for at in range(count)]
        return [
            date if is_date(date) else Reject("time_unusable", "after the year 9999")
            for date in dates
        ]

    def _each(self, payload: object, ways: tuple[Steps, ...], count: int) -> list[Date]:
        """Return the dates by one alternative; empty if it is absent."""
        lists: list[list[object]] = []
        for steps in ways:
            found = elements_at(payload, steps[: steps.index(EACH)])
            lists.append([] if isinstance(found, Reject) else found)
        if not any(lists):
            return []
        if {len(found) for found in lists if found} != {count}:
            lengths = " and ".join(str(len(found)) for found in lists)
            return [Reject("time_unusable", f"{lengths} dates for {count} samples")] * count
        rests = [steps[steps.index(EACH) + 1 :] for steps in ways]
        keys = [
            known[steps.index(EACH) + 1 :]
            for known, steps in zip(self._keys[ways], ways, strict=True)
        ]
        rows = zip(*(found or [MISSING] * count for found in lists), strict=True)
        return [self._judge(row, rests, keys) or self._nothing for row in rows]

    def _judge(
        self, places: Sequence[object], ways: Sequence[Steps], keys: Sequence[Sequence[Keys]]
    ) -> Date | None:
        values = [follow(place, steps) for place, steps in zip(places, ways, strict=True)]
        if all(value is MISSING or value is None for value in values):
            return None
        for at, (value, steps) in enumerate(zip(values, ways, strict=True)):
            if isinstance(value, Reject):
                return Reject("time_unusable", value.detail)
            if (
                value is MISSING
                and self._absent_is_zero
                and is_left_out(places[at], steps, keys[at])
            ):
                values[at] = 0
        return date_ns(values, self.units, numeric_strings=self._numeric_strings)
