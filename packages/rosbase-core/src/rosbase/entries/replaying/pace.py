"""How fast a replay runs."""

from collections.abc import Callable

from rosbase.clock import Clock, SystemClock

__all__ = ["Pace"]

_NS_PER_S = 1_000_000_000
# A stop by a signal is seen this soon.
_LOOK_S = 0.05


class Pace:
    """Waits before each entry until its time has come in real time."""

    def __init__(self, rate: float = 1.0, machine: Clock | None = None) -> None:
        """Start with the first entry.

        Args:
            rate: Seconds of the recording for each second of real time.
            machine: The clock of real time.

        Raises:
            ValueError: The rate is not a positive number.
        """
        if not 0 < rate < float("inf"):
            raise ValueError(f"a rate is a positive number, not {rate!r}")
        self._rate = rate
        self._machine = machine or SystemClock()
        self._start_ns: int | None = None

    def wait(self, t_ns: int, is_over: Callable[[], object]) -> None:
        """Wait for the time of an entry, in nanoseconds since the start of the run.

        Args:
            t_ns: The time of the entry.
            is_over: Whether the wait should end.
        """
        now_ns = self._machine.monotonic_ns()
        if self._start_ns is None:
            self._start_ns = now_ns - int(t_ns / self._rate)
        due_ns = self._start_ns + int(t_ns / self._rate)
        while (left_ns := due_ns - self._machine.monotonic_ns()) > 0 and not is_over():
            self._machine.sleep(min(left_ns / _NS_PER_S, _LOOK_S))
