"""The clock of the machine in a replay: it stands still until the replay moves it."""

from rosbase.messages import Time

__all__ = ["VirtualClock"]

_NS_PER_S = 1_000_000_000
_FOR_EVER = 5_000_000


class VirtualClock:
    """Times come from the recording. Any thread may read it; only the replay's own moves it."""

    def __init__(self, start_date_ns: int, start_monotonic_ns: int) -> None:
        """Start at the beginning of the recorded run."""
        self._start_date_ns = start_date_ns
        self.start_ns = start_monotonic_ns
        """Monotonic time of the start of the run."""
        self._date_ns = start_date_ns
        self._slept_ns = 0
        self.t_ns = 0
        """Time since the start of the run."""
        self._last_t_ns = 0
        self._looks = 0

    def move_to(self, t_ns: int) -> None:
        """Set the time since the start of the run. The clock never goes back."""
        if t_ns > self.t_ns:  # noqa: PLR1730 - `max` takes twice as long
            self.t_ns = t_ns

    def mono_read(self, value_ns: int) -> int:
        """Move to a recorded reading, in nanoseconds since the start; return the absolute one."""
        if value_ns > self.t_ns:  # noqa: PLR1730 - `max` takes twice as long
            self.t_ns = value_ns
        return self.start_ns + value_ns

    def date_read(self, value_ns: int) -> int:
        """Move the date to a recorded reading, since the date of the start; return the date."""
        # The date may be set while the program runs.
        self._date_ns = self._start_date_ns + value_ns - self.t_ns
        return self._start_date_ns + value_ns

    def slept_read(self, value_ns: int) -> int:
        """Note a recorded reading of `suspended_ns`, and return it."""
        self._slept_ns = value_ns
        return value_ns

    def now(self) -> Time:
        """Return the date as a stamp; zero if ROS cannot carry it."""
        return Time.as_stamp(self.now_ns())

    def now_ns(self) -> int:
        """Return the date in nanoseconds since the Unix epoch."""
        return self._date_ns + self.t_ns

    def monotonic_ns(self) -> int:
        """Return the monotonic time, as the recorded program saw it.

        Raises:
            RuntimeError: Millions of readings, and time stands still.
        """
        self.look()
        return self.start_ns + self.t_ns

    def suspended_ns(self) -> int:
        """Return for how long the machine had slept at the last recorded reading."""
        return self._slept_ns

    def sleep(self, seconds: float) -> None:
        """Move on by that duration."""
        self.t_ns += max(0, round(seconds * _NS_PER_S))

    def look(self) -> None:
        """Note that the program has read the clock, and the recording has no such reading.

        Raises:
            RuntimeError: Millions of readings, and time stands still.
        """
        if self.t_ns != self._last_t_ns:
            self._last_t_ns, self._looks = self.t_ns, 0
        self._looks += 1
        if self._looks > _FOR_EVER:
            self._looks = 0
            raise RuntimeError("the replay stands still: does a loop wait for time to pass?")
