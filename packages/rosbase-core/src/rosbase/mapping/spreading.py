"""Stamps for the samples of one message, of which only the arrival of the message is known."""

from collections import deque
from statistics import median_low

__all__ = ["Spreading"]

_MESSAGES = 15


class Spreading:
    """Spreads the samples of each message over the time since the message before.

    The last sample has the stamp of the message. Samples are never farther apart than they
    usually are: a pause before a message says nothing of the samples in it.
    """

    def __init__(self) -> None:
        """Begin before the first message."""
        self._last_ns: int | None = None
        # How far apart the samples of the last messages were, as far as that is known.
        self._steps_ns: deque[int] = deque(maxlen=_MESSAGES)

    def stamps(self, count: int, stamp_ns: int, interval_ns: int | None = None) -> list[int]:
        """Return the stamps of the samples of a message, in nanoseconds; they strictly rise.

        Args:
            count: The number of samples.
            stamp_ns: The stamp of the message, which is that of its last sample.
            interval_ns: The time from one sample to the next, if the payload tells it.
        """
        gap_ns = 0 if self._last_ns is None else stamp_ns - self._last_ns
        self._last_ns = stamp_ns
        # None reaches back to the message before, unless the clock was set back.
        room_ns = gap_ns // count if gap_ns > 0 else None
        known = [ns for ns in (interval_ns or self._usual_ns(), room_ns) if ns is not None]
        step_ns = max(1, min(known, default=1))
        if room_ns is not None:
            self._steps_ns.append(room_ns)
        return [stamp_ns - step_ns * (count - 1 - at) for at in range(count)]

    def _usual_ns(self) -> int | None:
        """How far apart samples usually are; None before the second message."""
        return median_low(self._steps_ns) if self._steps_ns else None
