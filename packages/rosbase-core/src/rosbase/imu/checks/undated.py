"""Report a device's time that was asked for but is never usable."""

from rosbase.mapping.rejects import Reject

__all__ = ["Undated"]

# One bad date among good ones is counted, and no more.
_IN_A_ROW = 20


class Undated:
    """Watches whether samples have the date for their stamps."""

    __slots__ = ("_in_a_row", "finding")

    def __init__(self) -> None:
        self.finding = ""
        """Reason why no sample has a usable date, in one line; empty if some have."""
        self._in_a_row = 0

    def add(self, fault: Reject | None) -> None:
        """Take the fault of a sample's date, or None if there is none."""
        if fault is None:
            self._in_a_row, self.finding = 0, ""
            return
        self._in_a_row += 1
        if self._in_a_row >= _IN_A_ROW:
            self.finding = (
                f"the device's time is unusable, samples are stamped on arrival: {fault.detail}"
            )
