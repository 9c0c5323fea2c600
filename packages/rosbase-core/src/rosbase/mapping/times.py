"""When the device says that it measured: the readers of `mapping.time`."""

from collections.abc import Sequence
from typing import TypeAlias

from attrs import frozen

from rosbase.errors import MappingError
from rosbase.mapping.dates import TIME_UNITS, date_ns, is_date
from rosbase.mapping.following import MISSING, follow
from rosbase.mapping.intervals import IntervalReader, compile_interval
from rosbase.mapping.path_text import parse_path
from rosbase.mapping.paths import EACH, Path, Steps, Way, show_steps, variants
from rosbase.mapping.rejects import Reject
from rosbase.mapping.surplus import elements_at

__all__ = ["Date", "Dates", "TimeMapping"]

Date: TypeAlias = int | Reject
"""Nanoseconds since 1970, or why there are none."""


@frozen
class TimeMapping:
    """Where the date of a sample is, in which unit, and how far apart samples of a message are."""

    paths: tuple[str, ...] = ()
    """A path to a number or an ISO 8601 text, or two: to the seconds and to the nanoseconds."""
    unit: str = ""
    """The unit of a lone number: `s`, `ms`, `us` or `ns`."""
    interval: str = ""
    """The time between two samples of one message, such as `5 ms` or `rate Hz`."""

    def check(self, *, is_batch: bool, is_wanted: bool) -> None:
        """Check what is there, whether or not dates are read.

        Args:
            is_batch: Whether a message holds several samples.
            is_wanted: Whether dates are read.

        Raises:
            MappingError: It cannot be, or has no effect.
        """
        if len(self.paths) > 2:
            raise MappingError("mapping.time.paths takes one path, or seconds and nanoseconds")
        if len(self.paths) == 1 and self.unit not in TIME_UNITS:
            units = ", ".join(TIME_UNITS)
            raise MappingError(f"mapping.time.unit is one of {units}, not {self.unit!r}")
        if len(self.paths) != 1 and self.unit:
            raise MappingError("mapping.time.unit has no effect without one path of time")
        if self.interval and not is_batch:
            raise MappingError("mapping.time.interval has no effect without [*] in mapping.*.paths")
        if is_wanted and not self.paths:
            raise MappingError("the device's time is wanted, but mapping.time.paths is empty")
        self._check_ways(is_batch=is_batch, is_wanted=is_wanted)

    def _check_ways(self, *, is_batch: bool, is_wanted: bool) -> None:
        ways = [way for path in self.parsed() for way in path]
        if any(way.sign < 0 for way in ways):
            raise MappingError("mapping.time.paths takes no minus")
        each = {EACH in way.steps for way in ways}
        if len(each) == 2 or (is_wanted and True in each and not is_batch):
            raise MappingError("[*] is in all of mapping.time.paths and of the quantities, or none")
        if is_wanted and is_batch and True not in each and not self.interval:
            raise MappingError(
                "one date for several samples: put [*] into mapping.time.paths, or set "
                "mapping.time.interval"
            )

    def parsed(self) -> list[Path]:
        """Return the paths.

        Raises:
            MappingError: One is none, or they have different numbers of alternatives.
        """
        paths = [parse_path(text) for text in self.paths]
        variants(paths, "mapping.time")
        return paths

    def compile_interval(self, *, numeric_strings: bool) -> IntervalReader | None:
        """Return a reader of the interval, if there is one."""
        if not self.interval:
            return None
        return compile_interval(self.interval, numeric_strings=numeric_strings)

    def compile(self, *, numeric_strings: bool, absent_is_zero: bool) -> "Dates":
        """Return the readers of dates, once `check` has passed."""
        units = [TIME_UNITS[self.unit]] if len(self.paths) == 1 else [TIME_UNITS["s"], 1]
        return Dates(
            variants(self.parsed(), "mapping.time"), units, numeric_strings, absent_is_zero
        )


class Dates:
    """Reads the dates of one message."""

    def __init__(
        self,
        alternatives: Sequence[tuple[Way, ...]],
        units: Sequence[int],
        numeric_strings: bool,
        absent_is_zero: bool,
    ) -> None:
        self._alternatives = [tuple(way.steps for way in ways) for ways in alternatives]
        self.first_ways = self._alternatives[0]
        self._has_each = any(EACH in steps for steps in self._alternatives[0])
        self.units = units
        self._numeric_strings = numeric_strings
        self._absent_is_zero = absent_is_zero
        self._nothing = Reject(
            "time_unusable", f"nothing at {show_steps(self._alternatives[0][0])}"
        )

    def date(self, payload: object) -> Date:
        """Return the date of a payload with one sample."""
        for ways in self._alternatives:
            date = self._judge([payload] * len(ways), ways)
            if date is not None:
                return date
        return self._nothing

    def dates(self, payload: object, count: int, interval_ns: int | None) -> list[Date]:
        """Return the dates of the samples of a payload.

        Args:
            payload: Has a date for each sample, or one for the first.
            count: The number of samples.
            interval_ns: The time from one sample to the next, if it is known.
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
        return [date if is_date(date) else Reject("time_unusable", "after 2038") for date in dates]

    def _each(self, payload: object, ways: Sequence[Steps], count: int) -> list[Date]:
        """The dates by one alternative; empty if there is nothing of it."""
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
        rows = zip(*(found or [MISSING] * count for found in lists), strict=True)
        return [self._judge(row, rests) or self._nothing for row in rows]

    def _judge(self, places: Sequence[object], ways: Sequence[Steps]) -> Date | None:
        values = [follow(place, steps) for place, steps in zip(places, ways, strict=True)]
        if all(value is MISSING or value is None for value in values):
            return None
        for at, (value, steps) in enumerate(zip(values, ways, strict=True)):
            if isinstance(value, Reject):
                return Reject("time_unusable", value.detail)
            if value is MISSING and self._absent_is_zero and steps and isinstance(steps[-1], str):
                values[at] = 0
        return date_ns(values, self.units, numeric_strings=self._numeric_strings)
