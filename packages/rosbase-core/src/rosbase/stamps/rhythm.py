"""The usual interval of a stream's frames, and the jitter of their arrival."""

__all__ = ["Rhythm"]

# So many arrivals are seen before the usual interval is known. The longest wait among them is
# left out: it may be the one before the device began.
_LEARNED = 8
# The interval is the mean of all frames, and once there are so many, an average that forgets.
_REMEMBERED = 64
# As in RFC 3550.
_JITTER_SHIFT = 4


class Rhythm:
    """Running estimates of the interval between frames and of the jitter of their arrival.

    Deviations of more than four intervals count as four. So a pause, or a burst after one,
    changes little. A new rate is learned within some hundred frames.
    """

    __slots__ = ("_last_ns", "_learned", "_remembered", "interval_ns", "jitter_ns")

    def __init__(self) -> None:
        """Start without an estimate."""
        self.interval_ns = 0
        """Usual time between two frames; 0 while it is not known."""
        self.jitter_ns = 0
        """Average deviation of arrivals from the usual interval."""
        self._last_ns: int | None = None
        self._learned: list[tuple[int, int]] = []
        self._remembered = 0

    def pause(self) -> None:
        """Forget when the last frame came: the time until the next one is not an interval."""
        self._last_ns = None

    def add(self, count: int, at_ns: int) -> None:
        """Take `count` frames since the last call, the last of them at `at_ns` (monotonic)."""
        last_ns, self._last_ns = self._last_ns, at_ns
        if last_ns is None:
            return
        usual_ns = self.interval_ns
        if not usual_ns:
            self._learn(at_ns - last_ns, count)
            return
        most_ns = usual_ns << 2
        off_ns = max(-most_ns, min(most_ns, at_ns - last_ns - count * usual_ns))
        self._remembered = min(self._remembered + count, _REMEMBERED)
        self.interval_ns = usual_ns + off_ns // self._remembered
        self.jitter_ns += (abs(off_ns) - self.jitter_ns) >> _JITTER_SHIFT

    def _learn(self, wait_ns: int, count: int) -> None:
        self._learned.append((wait_ns, count))
        if len(self._learned) == _LEARNED:
            usual = sorted(self._learned)[:-1]
            self._learned = []
            self._remembered = sum(number for _, number in usual)
            self.interval_ns = sum(wait for wait, _ in usual) // self._remembered
