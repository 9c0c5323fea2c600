"""Whether the device's dates go on: what is delivered again, or late, must not be published."""

from rosbase.imu.mapping import Sample
from rosbase.mapping.rejects import Reject

__all__ = ["DateOrder"]

# What a network holds up is through by then; a clock that was set back stays behind.
_PATIENCE_NS = 2_000_000_000


class DateOrder:
    """Compares each sample with the last that went through.

    Where everything has been earlier for two seconds, the device's clock was set back, or had
    once been far ahead; the dates are taken as they are from there on.
    """

    def __init__(self) -> None:
        """Takes the first sample, whatever its date."""
        self._last: Sample | None = None
        self._last_ns = 0
        self._late_since_ns = 0

    def judge(self, sample: Sample, date_ns: int, arrived_ns: int) -> Reject | None:
        """Why the sample is to be dropped, if it is.

        Args:
            sample: What the payload says.
            date_ns: Its date, in nanoseconds since the epoch.
            arrived_ns: When it arrived, in nanoseconds since the epoch.
        """
        if date_ns == self._last_ns and sample == self._last:
            return Reject("duplicate")
        if date_ns < self._last_ns:
            if not 0 < self._late_since_ns <= arrived_ns:
                # The first that is late; or the clock here was set back too, as one time server
                # does with both.
                self._late_since_ns = arrived_ns
            if arrived_ns - self._late_since_ns < _PATIENCE_NS:
                late_s = (self._last_ns - date_ns) / 1e9
                return Reject("out_of_order", f"{late_s:.3f} s before the last one")
        self._last, self._last_ns, self._late_since_ns = sample, date_ns, 0
        return None
