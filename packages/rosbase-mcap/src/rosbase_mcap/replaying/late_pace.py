"""How fast a replay runs that only has to come to a later moment."""

from collections.abc import Callable

from rosbase.entries.replaying.pace import Pace

__all__ = ["LatePace"]


class LatePace(Pace):
    """Runs as fast as possible up to a moment, and keeps the pace from there on."""

    def __init__(self, rate: float, start_ns: int) -> None:
        """Prepare.

        Args:
            rate: Seconds of the recording for each second of real time.
            start_ns: The moment, in nanoseconds since the start of the run.
        """
        super().__init__(rate)
        self._from_ns = start_ns

    def wait(self, t_ns: int, is_over: Callable[[], object]) -> None:
        """Wait for the time of an entry, if it is late enough."""
        if t_ns >= self._from_ns:
            super().wait(t_ns, is_over)
