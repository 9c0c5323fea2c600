"""Notices when somebody sets the system clock, which changes stamps and nothing else."""

from types import TracebackType

from rosbase.backend import Backend
from rosbase.logger import RosbaseLogger

__all__ = ["ClockWatch"]

_EVERY_S = 1.0
_NS_PER_S = 1_000_000_000
# NTP slews by less than 1 ms in a second; what is more than this is a step.
_STEP_NS = 100_000_000


class ClockWatch:
    """Compares the date with the monotonic clock, once a second, as long as the context lasts."""

    def __init__(self, backend: Backend, logger: RosbaseLogger) -> None:
        self._backend = backend
        self._logger = logger
        self._offset_ns = self._read()

    def __enter__(self) -> None:
        """Begins to watch."""
        self._timer = self._backend.create_timer(_EVERY_S, self._check)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        """Watches no more."""
        self._backend.destroy_timer(self._timer)

    def _read(self) -> int:
        clock = self._backend.clock
        return clock.now_ns() - clock.monotonic_ns()

    def _check(self) -> None:
        offset_ns = self._read()
        step_ns, self._offset_ns = offset_ns - self._offset_ns, offset_ns
        if abs(step_ns) >= _STEP_NS:
            way = "forward" if step_ns > 0 else "back"
            seconds = abs(step_ns) / _NS_PER_S
            self._logger.warning(f"the system clock was set {way} by {seconds:.1f} s")
