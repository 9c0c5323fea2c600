"""Where a recording is while it is played. Pure."""

import math

__all__ = ["Playhead"]


class Playhead:
    """Moves through the time of a recording while the machine's time passes."""

    def __init__(self, begin_ns: int, end_ns: int) -> None:
        """Stand at the beginning.

        Args:
            begin_ns: Where the recording begins, in nanoseconds since 1970.
            end_ns: Where it ends.
        """
        self.begin_ns, self.end_ns = begin_ns, max(begin_ns, end_ns)
        self.is_playing = False
        self.rate = 1.0
        self._from_ns = begin_ns
        self._since_ns = 0

    def at(self, now_ns: int) -> int:
        """Return where the recording is at a monotonic time; it ends at its end."""
        passed_ns = now_ns - self._since_ns if self.is_playing else 0
        return min(self.end_ns, self._from_ns + int(passed_ns * self.rate))

    def play(self, now_ns: int) -> None:
        """Go on from here."""
        self._stay(now_ns)
        self.is_playing = True

    def pause(self, now_ns: int) -> None:
        """Stand still here."""
        self._stay(now_ns)
        self.is_playing = False

    def seek(self, to_ns: int, now_ns: int) -> None:
        """Go to a time; to the nearest end if it lies outside."""
        self._from_ns = max(self.begin_ns, min(to_ns, self.end_ns))
        self._since_ns = now_ns

    def set_rate(self, rate: float, now_ns: int) -> None:
        """Go on from here at another speed.

        Raises:
            ValueError: It is not greater than 0, or not finite.
        """
        if not 0.0 < rate < math.inf:
            raise ValueError(f"a speed is finite and greater than 0, not {rate}")
        self._stay(now_ns)
        self.rate = rate

    def due_ns(self, stamp_ns: int, now_ns: int) -> int:
        """Return how long it takes until a time is reached, in nanoseconds of the machine."""
        return max(0, int((stamp_ns - self.at(now_ns)) / self.rate))

    def _stay(self, now_ns: int) -> None:
        self._from_ns, self._since_ns = self.at(now_ns), now_ns
