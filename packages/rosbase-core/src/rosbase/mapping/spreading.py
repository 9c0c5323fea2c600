"""Stamp the samples of a message whose arrival is the only known time."""

from collections import deque
from statistics import median_low

__all__ = ["Spreading"]

_MESSAGES = 15


class Spreading:
    """Spreads the samples of each message over the time since the message before.

    The last sample has the stamp of the message. Samples are never farther apart than usual,
    because a pause before a message is no pause between its samples.
    """

    def __init__(self) -> None:
        """Begin before the first message."""
        self._last_ns: int | None = None
        # The time between samples in the last messages.
        self._steps_ns: deque[int] = deque(maxlen=_MESSAGES)

    def stamps(self, count: int, stamp_ns: int, interval_ns: int | None = None) -> list[int]:
        """Return the stamps of the samples of a message, in nanoseconds; they strictly rise.

        Args:
            count: The number of samples.
            stamp_ns: The stamp of the message and of its last sample.
            interval_ns: The time between two samples, if the mapping gives it.
        """
        gap_ns = 0 if self._last_ns is None else stamp_ns - self._last_ns
        self._last_ns = stamp_ns
        # The samples must not reach back to the message before, unless the clock was set back.
        room_ns = gap_ns // count if gap_ns > 0 else None
        known = [ns for ns in (interval_ns or self._usual_ns(), room_ns) if ns is not None]
        step_ns = max(1, min(known, default=1))
        if room_ns is not None:
            self._steps_ns.append(room_ns)
        return [stamp_ns - step_ns * (count - 1 - at) for at in range(count)]

    def _usual_ns(self) -> int | None:
        """Return the usual time between samples; None before the second message."""
        return median_low(self._steps_ns) if self._steps_ns else None
