"""Log the measured rate of the main loop."""

from rosbase.clock import Clock
from rosbase.logger import RosbaseLogger
from rosbase.runtime.rate import LoopStats

__all__ = ["FrequencyLog"]

_PERIOD_NS = 1_000_000_000


class FrequencyLog:
    """Logs the rate of the last second, at most once a second."""

    def __init__(self, clock: Clock, stats: LoopStats, logger: RosbaseLogger) -> None:
        self._clock = clock
        self._stats = stats
        self._logger = logger
        self._mark: tuple[int, int] | None = None

    def check(self) -> None:
        """Log the rate if it is time. Called now and then between ticks."""
        now_ns, ticks = self._clock.monotonic_ns(), self._stats.ticks
        since_ns, before = self._mark or (now_ns, ticks)
        if self._mark is None or now_ns - since_ns >= _PERIOD_NS:
            if ticks > before:
                rate_hz = (ticks - before) * 1e9 / (now_ns - since_ns)
                self._logger.info(f"main loop: {rate_hz:.1f} Hz")
            self._mark = (now_ns, ticks)
