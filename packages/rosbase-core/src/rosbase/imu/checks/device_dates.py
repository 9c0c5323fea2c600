"""Decide which of the device's dates to believe: no stamp twice, backwards, or absurd."""

from collections import deque
from datetime import datetime, timedelta
from typing import TypeAlias

from rosbase.imu.checks.date_pace import DatePace
from rosbase.imu.checks.device_clock import DeviceClock
from rosbase.imu.mapping import Sample
from rosbase.mapping.rejects import Reject

__all__ = ["DeviceDates", "Verdict"]

Verdict: TypeAlias = int | Reject | None
"""Date for publishing, or the reason why the sample is dropped.

A sample with `time_unusable` is not dropped but stamped on arrival. So is one with None, whose
payload is known to have no date.
"""

_S = 1_000_000_000
_EPOCH = datetime(1970, 1, 1)
_DAY_NS = 86_400 * _S

# No device that is in use has measured before; a ROS stamp ends in 2038.
_EARLIEST_NS = 946_684_800 * _S
_LATEST_NS = (2**31 - 1) * _S

# What a network holds up is through by then; a clock that was set back stays behind.
_PATIENCE_NS = 2 * _S
# Dates that differ from the arrival by the same, give or take this, are of one clock.
_NEAR_NS = 2 * _S
# A date this near to its arrival is right, where the dates before it were wrong.
_ARRIVAL_NS = 60 * _S
# So many that agree are no accident; in between there may be absurd ones.
_AGREEMENT = 3
_DOUBTED = 5
# What a network has held up is late by less; what is earlier is no date of this stream.
_LONGEST_DELAY_NS = 3600 * _S


class DeviceDates:
    """Compares each date with the dates before it, and with the arrival.

    A date that jumps ahead is believed at once if it agrees with the arrival, or else when
    three of the last five agree. If all dates have been earlier for two seconds, and agree
    too, the device's clock was set back. From then on its dates are believed again.
    """

    def __init__(self, clock: DeviceClock | None = None, *, is_strict: bool = False) -> None:
        """Start without earlier dates.

        Args:
            clock: Judges the device's clock; None to skip this.
            is_strict: Whether to reject dates that are further from their arrival than the clock
                may be wrong.
        """
        self._clock = clock
        self._limit_ns = clock.limit_ns if clock and is_strict else None
        self._last: Sample | None = None
        self._last_ns = 0
        # By how much the run is ahead of the arrival, as told by what came without delay.
        self._ahead_ns = 0
        self._believed_at_ns = 0
        self._late_since_ns = 0
        self._doubted = _Agreement()
        self._pace = DatePace()

    @property
    def finding(self) -> str:
        """Fault of the device's clock, in one line; empty if there is none."""
        of_clock = self._clock.finding if self._clock else ""
        return "; ".join(filter(None, (of_clock, self._pace.finding)))

    def judge(self, sample: Sample, arrived_ns: int) -> Verdict:
        """Decide with which date a sample is published.

        Args:
            sample: A sample and its date, which may be any from 1980 on.
            arrived_ns: When it arrived, in nanoseconds since the epoch.
        """
        date_ns = sample.device_time_ns
        if date_ns is None or not _EARLIEST_NS <= date_ns < _LATEST_NS:
            return self._without_date(date_ns, arrived_ns)
        ahead_ns = date_ns - arrived_ns
        if self._last is not None and date_ns <= self._last_ns:
            refusal = self._look_back(sample, date_ns, arrived_ns)
            if refusal is not None:
                return refusal
        leaps = self._leaps(date_ns, ahead_ns)
        if leaps and not self._doubted.add(date_ns, ahead_ns):
            return self._doubt(date_ns, arrived_ns)
        is_same_run = self._last is not None and date_ns >= self._last_ns and not leaps
        self._ahead_ns = max(self._ahead_ns, ahead_ns) if is_same_run else ahead_ns
        self._last, self._last_ns, self._believed_at_ns = sample, date_ns, arrived_ns
        self._late_since_ns = 0
        self._doubted.forget()
        refusal = self._compare_with_arrival(date_ns, ahead_ns, arrived_ns)
        return self._pace.stamp(date_ns, arrived_ns) if refusal is None else refusal

    def _leaps(self, date_ns: int, ahead_ns: int) -> bool:
        """Return whether a date is far from all known dates."""
        if self._last is None:
            return abs(ahead_ns) > _DAY_NS and _is_known(date_ns - ahead_ns)
        # Dates that follow each other are of one run, even if the clock here is set.
        is_later = date_ns - self._last_ns > _NEAR_NS
        is_ahead = ahead_ns - self._ahead_ns > _NEAR_NS
        return is_later and is_ahead and not self._agrees_with_arrival(ahead_ns)

    def _agrees_with_arrival(self, ahead_ns: int) -> bool:
        """Return whether a date is right, as far as the arrival can tell."""
        is_run_wrong = abs(self._ahead_ns) > 2 * _ARRIVAL_NS
        return abs(ahead_ns) <= (self._limit_ns or (_ARRIVAL_NS if is_run_wrong else _NEAR_NS))

    def _doubt(self, date_ns: int, arrived_ns: int) -> Verdict:
        if not self._believed_at_ns:
            self._believed_at_ns = arrived_ns
        if self._is_recent(self._believed_at_ns, arrived_ns):
            return _implausible(date_ns)
        # There is no run any more, and the arrival is a date that is right.
        return _unusable(date_ns)

    def _look_back(self, sample: Sample, date_ns: int, arrived_ns: int) -> Reject | None:
        """Return why a sample that is not later than the last one is dropped, if it is."""
        late_ns = self._last_ns - date_ns
        if not late_ns:
            self._late_since_ns = 0
            return Reject("duplicate") if sample == self._last else None
        ahead_ns, run_ahead_ns = date_ns - arrived_ns, self._last_ns - arrived_ns
        if self._agrees_with_arrival(ahead_ns) and not self._agrees_with_arrival(run_ahead_ns):
            # The run was wrong, and this is right.
            return None
        if not 0 < self._late_since_ns <= arrived_ns:
            # The first that is late; or the clock here was set back too, as one time server
            # does with both.
            self._late_since_ns = arrived_ns
        agrees = self._doubted.add(date_ns, ahead_ns)
        if agrees and arrived_ns - self._late_since_ns >= _PATIENCE_NS:
            return None
        if late_ns > _LONGEST_DELAY_NS:
            return _implausible(date_ns)
        return Reject("out_of_order", f"{late_ns / _S:.3f} s before the last one")

    def _without_date(self, date_ns: int | None, arrived_ns: int) -> Verdict:
        # Among dates no absurd one fits in; and no arrival, where the device's clock is wrong.
        is_among_dates = self._last is not None and self._is_recent(
            self._believed_at_ns, arrived_ns
        )
        if date_ns is not None:
            return _implausible(date_ns) if is_among_dates else _unusable(date_ns)
        if is_among_dates and abs(self._ahead_ns) > _NEAR_NS:
            return Reject("implausible_date", "no date, and the device's clock is wrong")
        return None

    def _compare_with_arrival(self, date_ns: int, ahead_ns: int, arrived_ns: int) -> Reject | None:
        if self._clock is None or not _is_known(arrived_ns):
            return None
        self._clock.add(ahead_ns, arrived_ns)
        if self._limit_ns is None or abs(ahead_ns) <= self._limit_ns:
            return None
        # It may be late, or the clock wrong; the clock's judgement tells after two seconds.
        return _unusable(date_ns) if self._clock.finding else _implausible(date_ns)

    @staticmethod
    def _is_recent(then_ns: int, now_ns: int) -> bool:
        return 0 <= now_ns - then_ns < _PATIENCE_NS


class _Agreement:
    """Remembers the last doubtful dates, and counts those that agree with each other."""

    def __init__(self) -> None:
        self._doubted: deque[tuple[int, int]] = deque(maxlen=_DOUBTED)

    def add(self, date_ns: int, ahead_ns: int) -> bool:
        """Take a date; return whether it and enough others agree on a running clock."""
        if all(date_ns != other_ns for other_ns, _ in self._doubted):
            # A coarse clock repeats its dates, and so does a stuck one.
            self._doubted.append((date_ns, ahead_ns))
        agreeing = [a for d, a in self._doubted if d <= date_ns and abs(a - ahead_ns) <= _NEAR_NS]
        return len(agreeing) >= _AGREEMENT

    def forget(self) -> None:
        """Forget all dates."""
        if self._doubted:
            self._doubted.clear()


def _is_known(arrived_ns: int) -> bool:
    """Return whether the arrival has a valid date: on a machine with an absurd date it has none."""
    return _EARLIEST_NS <= arrived_ns < _LATEST_NS


def _implausible(date_ns: int) -> Reject:
    return Reject("implausible_date", _dated(date_ns))


def _unusable(date_ns: int) -> Reject:
    return Reject("time_unusable", f"{_dated(date_ns)}; are clock and mapping.time.unit right?")


def _dated(date_ns: int) -> str:
    date = _EPOCH + timedelta(seconds=date_ns // _S)
    return f"dated {date:%Y-%m-%d %H:%M:%S} UTC"
