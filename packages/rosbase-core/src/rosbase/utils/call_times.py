"""The times of the calls of one function: warnings, and a report in each interval."""

import math
from itertools import pairwise

from rosbase.clock import Clock
from rosbase.logger import RosbaseLogger
from rosbase.utils.durations import Durations

__all__ = ["MANY_CALLS", "CallTimes"]

MANY_CALLS = 1000
"""Number of times after which they are digested, which is cheaper for many than for one."""

_NS_PER_S = 1_000_000_000
_NS_PER_MS = 1e6


class CallTimes:
    """Times of the calls of one function, of one object if it is a method.

    The attributes are for `profile_latency`, which compares and sets them in each call.
    """

    __slots__ = (
        "_age",
        "_clock",
        "_cycle",
        "_interval_ns",
        "_last_ns",
        "_logger",
        "_name",
        "_process",
        "calls",
        "cycle_ns",
        "due_ns",
        "late_ns",
        "long_ns",
        "read_ns",
    )

    def __init__(
        self,
        name: str,
        clock: Clock,
        logger: RosbaseLogger,
        cycle_threshold_ms: float,
        process_threshold_ms: float,
        interval_s: float,
    ) -> None:
        """Begin the first interval."""
        self._name, self._clock, self._logger = name, clock, logger
        self._cycle = Durations("cycle", cycle_threshold_ms)
        self._process = Durations("process", process_threshold_ms)
        self._age = Durations("age of the stamp")
        self._interval_ns = int(interval_s * _NS_PER_S)
        self._last_ns: int | None = None
        self.read_ns = clock.monotonic_ns
        """Reads the time."""
        self.calls: list[int] = []
        """Start and end of each call, in turns."""
        self.late_ns = math.inf
        """Time from which the next call is late."""
        self.cycle_ns = self._cycle.threshold_ns
        """Longest time between two calls without a warning."""
        self.long_ns = self._process.threshold_ns
        """Longest time of a call without a warning."""
        self.due_ns = self.read_ns() + self._interval_ns
        """Time of the next report."""

    def look_at(self, start_ns: int, end_ns: int) -> None:
        """Warn of the last call, if it was late or long, and write the report, if it is due."""
        late_ns = start_ns - (self.late_ns - self.cycle_ns)
        if late_ns > self.cycle_ns:
            self._warn(self._cycle, late_ns)
            self.cycle_ns = math.inf
        if end_ns - start_ns > self.long_ns:
            self._warn(self._process, end_ns - start_ns)
            self.long_ns = math.inf
        if end_ns >= self.due_ns:
            self._report()
            # Warnings begin anew.
            self.cycle_ns, self.long_ns = self._cycle.threshold_ns, self._process.threshold_ns
            self.due_ns = end_ns + self._interval_ns
        elif len(self.calls) > MANY_CALLS:
            self._digest()

    def add_age(self, arguments: tuple[object, ...], since_ns: int) -> None:
        """Add the age of the first message among the arguments, when the call began."""
        stamp_ns = _stamp_in(arguments)
        if stamp_ns:
            self._age.add([self._clock.now_ns() - since_ns - stamp_ns])

    def _warn(self, durations: Durations, duration_ns: float) -> None:
        self._logger.warning(
            f"{self._name}: {durations.name} took {duration_ns / _NS_PER_MS:.3f} ms,"
            f" more than {durations.threshold_ns / _NS_PER_MS:g}"
        )

    def _digest(self) -> None:
        calls, self.calls = self.calls, []
        starts, ends = calls[::2], calls[1::2]
        self._process.add([end - start for start, end in zip(starts, ends, strict=True)])
        before = [] if self._last_ns is None else [self._last_ns]
        self._cycle.add([later - earlier for earlier, later in pairwise([*before, *starts])])
        self._last_ns = starts[-1]

    def _report(self) -> None:
        self._digest()
        kinds = (self._cycle, self._process, self._age)
        self._logger.info(f"{self._name}: {'; '.join(filter(None, map(Durations.report, kinds)))}")
        for kind in kinds:
            kind.clear()


def _stamp_in(arguments: tuple[object, ...]) -> int:
    """Return the stamp of the first message in nanoseconds; 0 if there is none."""
    for argument in arguments:
        stamp = getattr(getattr(argument, "header", None), "stamp", None)
        if stamp is not None and hasattr(stamp, "nanosec"):
            return int(stamp.sec) * _NS_PER_S + int(stamp.nanosec)
    return 0
