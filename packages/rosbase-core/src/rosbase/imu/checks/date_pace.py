"""Stamps that rise although the device's dates repeat: the arrival decides between two dates."""

__all__ = ["DatePace"]

# One date that repeats is nothing to speak of.
_IN_A_ROW = 20


class DatePace:
    """Makes stamps from dates that a coarse clock repeats, such as dates of whole seconds.

    A date that is later than the last stamp is the stamp. Otherwise the stamp is the last one
    plus the time between the arrivals. If the stamps have run ahead of the dates, only half of
    that time is added, until the dates have caught up.
    """

    __slots__ = ("_arrived_ns", "_date_ns", "_in_a_row", "_stamp_ns", "finding")

    def __init__(self) -> None:
        """Start without a date."""
        self._date_ns = self._stamp_ns = self._arrived_ns = 0
        self._in_a_row = 0
        self.finding = ""
        """Fault of the dates, in one line; empty if there is none."""

    def stamp(self, date_ns: int, arrived_ns: int) -> int:
        """Return the stamp of a sample that is published.

        Args:
            date_ns: Its date. A date before the last one starts again, as after a clock that was
                set back.
            arrived_ns: When it arrived. Arrivals rise, unless the clock of the machine is set.
        """
        passed_ns = arrived_ns - self._arrived_ns
        is_set_back = date_ns < self._date_ns
        if date_ns > self._stamp_ns or is_set_back or passed_ns <= 0:
            self._stamp_ns = date_ns if is_set_back else max(date_ns, self._stamp_ns + 1)
            self._note_repeat(is_repeated=not is_set_back and self._stamp_ns != date_ns)
        else:
            if date_ns > self._date_ns:
                passed_ns //= 2
            self._stamp_ns += max(passed_ns, 1)
            self._note_repeat(is_repeated=True)
        self._date_ns, self._arrived_ns = date_ns, arrived_ns
        return self._stamp_ns

    def _note_repeat(self, *, is_repeated: bool) -> None:
        if is_repeated:
            self._in_a_row = min(self._in_a_row + 1, 2 * _IN_A_ROW)
        elif self._in_a_row:
            self._in_a_row -= 1
        if self._in_a_row >= _IN_A_ROW and not self.finding:
            self.finding = (
                "the device's dates repeat: its clock is coarser than the rate of its samples."
                " Samples between two dates are stamped on arrival"
            )
        elif not self._in_a_row:
            self.finding = ""
