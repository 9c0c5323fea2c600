"""Whether the device's time is of any use: what is asked for and never there must be said."""

from rosbase.mapping.rejects import Reject

__all__ = ["Undated"]

# One bad date among good ones is counted, and no more.
_IN_A_ROW = 20


class Undated:
    """Watches whether samples have the date that they are to be stamped with."""

    __slots__ = ("_in_a_row", "finding")

    def __init__(self) -> None:
        self.finding = ""
        """Why no sample has a usable date, in one line; empty if some have."""
        self._in_a_row = 0

    def add(self, fault: Reject | None) -> None:
        """Take what is wrong with the date of one sample, or None if nothing is."""
        if fault is None:
            self._in_a_row, self.finding = 0, ""
            return
        self._in_a_row += 1
        if self._in_a_row >= _IN_A_ROW:
            self.finding = f"the device's time is unusable, stamps are of arrival: {fault.detail}"
