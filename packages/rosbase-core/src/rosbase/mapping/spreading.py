"""Stamp the samples of a message whose arrival is the only known time."""

from collections import deque

from rosbase.stamps import spread

__all__ = ["Spreading"]

_MESSAGES = 15


class Spreading:
    """Spreads the samples of each message over the time since the message before.

    The last sample has the stamp of the message. Samples are never further apart than usual,
    because a pause before a message is no pause between its samples.
    """

    def __init__(self) -> None:
        """Start before the first message."""
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
        last_ns, self._last_ns = self._last_ns, stamp_ns
        widest_ns = interval_ns or self._usual_ns()
        if last_ns is None or last_ns >= stamp_ns:
            # There is no message before, or the clock was set back.
            last_ns = stamp_ns - count * (widest_ns or 1)
        else:
            self._steps_ns.append((stamp_ns - last_ns) // count)
        return list(spread(count, last_ns, stamp_ns, widest_ns))

    def _usual_ns(self) -> int | None:
        """Return the usual time between samples; None before the second message."""
        # The lower median. `statistics` costs half a millisecond at the start.
        steps_ns = sorted(self._steps_ns)
        return steps_ns[(len(steps_ns) - 1) // 2] if steps_ns else None
