"""How long before a deadline to end a sleep, so that a short spin meets it. Reads no clock."""

__all__ = ["EarlyWake"]

# A sleep ends some 50 to 150 us late, depending on the machine and on how deep the processor
# sleeps. With steps of nine to one, one sleep in ten ends after the deadline.
_LATER_NS = 900
_EARLIER_NS = 100
_FIRST_NS = 100_000
# A program whose callbacks delay the loop must not make it spin for ever.
_MOST_NS = 250_000


class EarlyWake:
    """Learns how late sleeps end: in nine of ten, by less than `margin_ns`."""

    __slots__ = ("_most_ns", "margin_ns")

    def __init__(self, period_ns: float) -> None:
        """Start with a margin that fits most machines.

        Args:
            period_ns: Time between two deadlines. The margin is at most half of it.
        """
        self._most_ns = min(_MOST_NS, int(period_ns / 2))
        self.margin_ns = min(_FIRST_NS, self._most_ns)
        """Nanoseconds between the end that a sleep is given and the deadline; never negative."""

    def note(self, left_ns: int) -> None:
        """Learn from one sleep.

        Args:
            left_ns: Time that was left until the deadline at its end; negative if it was late.
        """
        if left_ns < 0:
            self.margin_ns = min(self._most_ns, self.margin_ns + _LATER_NS)
        elif self.margin_ns > _EARLIER_NS:
            self.margin_ns -= _EARLIER_NS
