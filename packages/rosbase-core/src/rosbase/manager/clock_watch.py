"""Detect steps of the system clock, which change stamps and nothing else."""

from rosbase.clock import Clock
from rosbase.logger import RosbaseLogger

__all__ = ["ClockWatch"]

_NS_PER_S = 1_000_000_000
# NTP slews by less than 1 ms in a second; what is more than this is a step.
_STEP_NS = 100_000_000


class ClockWatch:
    """Compares the date with the monotonic clock, about once a second."""

    def __init__(self, clock: Clock, logger: RosbaseLogger) -> None:
        self._clock = clock
        self._logger = logger
        self._offset_ns = self._read()

    def _read(self) -> int:
        return self._clock.now_ns() - self._clock.monotonic_ns()

    def check(self) -> None:
        """Log a step of the date since the last check."""
        offset_ns = self._read()
        step_ns, self._offset_ns = offset_ns - self._offset_ns, offset_ns
        if abs(step_ns) >= _STEP_NS:
            way = "forward" if step_ns > 0 else "back"
            seconds = abs(step_ns) / _NS_PER_S
            self._logger.warning(f"the system clock was set {way} by {seconds:.1f} s")
