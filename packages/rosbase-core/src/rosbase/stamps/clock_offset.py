"""How far the date is ahead of the monotonic time, and whether somebody has set the date."""

__all__ = ["SLIGHT_NS", "ClockOffset"]

SLIGHT_NS = 1_000_000
"""Less than this is no step."""

# NTP slews by 500 ppm at most; twice as much is no step.
_SLEW_SHIFT = 10


class ClockOffset:
    """Compares the two clocks whenever it is asked.

    The two clocks of a machine differ by a constant until one of them is set. The date is read
    between two readings of the monotonic clock. So it is known how far the comparison may be
    off, also where somebody else had the processor in between.
    """

    __slots__ = ("_doubt_ns", "_measured_ns", "offset_ns")

    def __init__(self) -> None:
        """Know nothing yet."""
        self.offset_ns: int | None = None
        """Date minus monotonic time; None before the first comparison."""
        self._doubt_ns = self._measured_ns = 0

    def step(self, before_ns: int, date_ns: int, after_ns: int) -> int:
        """Return by how much the date has been set since the last comparison; 0 if it has not.

        Args:
            before_ns: The monotonic time before the date was read.
            date_ns: The date.
            after_ns: The monotonic time after that.
        """
        if self.offset_ns is None:
            self.take(before_ns, date_ns, after_ns)
            return 0
        drift_ns, uncertain_ns = date_ns - after_ns - self.offset_ns, after_ns - before_ns
        slack_ns = SLIGHT_NS + (after_ns - self._measured_ns >> _SLEW_SHIFT)
        # The true offset is between the measured one and that much more, now as it was then.
        if drift_ns > slack_ns + self._doubt_ns or drift_ns + uncertain_ns < -slack_ns:
            self.take(before_ns, date_ns, after_ns)
            return drift_ns
        if uncertain_ns < SLIGHT_NS:
            self.take(before_ns, date_ns, after_ns)
        return 0

    def take(self, before_ns: int, date_ns: int, after_ns: int) -> None:
        """Take the offset as it is now."""
        self.offset_ns, self._doubt_ns = date_ns - after_ns, after_ns - before_ns
        self._measured_ns = after_ns

    def shift(self, asleep_ns: int) -> None:
        """Note that the machine has slept, in which time only the date goes on."""
        if self.offset_ns is not None:
            self.offset_ns += asleep_ns
