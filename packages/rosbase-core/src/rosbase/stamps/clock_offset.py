"""Offset between the date and the monotonic time, and steps of the date."""

__all__ = ["SLIGHT_NS", "ClockOffset"]

SLIGHT_NS = 1_000_000
"""Offset changes below this are no step."""

# NTP slews by 500 ppm at most; twice as much is no step.
_SLEW_SHIFT = 10


class ClockOffset:
    """Compares the two clocks on each call.

    The two clocks of a machine differ by a constant until one of them is set. The date is read
    between two readings of the monotonic clock. So the maximum error of the comparison is
    known, even if another process had the processor in between.
    """

    __slots__ = ("_doubt_ns", "_measured_ns", "offset_ns")

    def __init__(self) -> None:
        """Start without an offset."""
        self.offset_ns: int | None = None
        """Date minus monotonic time; None before the first comparison."""
        self._doubt_ns = self._measured_ns = 0

    def step(self, before_ns: int, date_ns: int, after_ns: int) -> int:
        """Return the step of the date since the last comparison; 0 if there was none.

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
        """Take the current offset."""
        self.offset_ns, self._doubt_ns = date_ns - after_ns, after_ns - before_ns
        self._measured_ns = after_ns

    def shift(self, asleep_ns: int) -> None:
        """Note that the machine has slept. Only the date goes on during that time."""
        if self.offset_ns is not None:
            self.offset_ns += asleep_ns
