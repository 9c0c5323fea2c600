"""Limit the lines that a child may write into the log per second."""

__all__ = ["LineBudget"]

_NS_PER_S = 1_000_000_000


class LineBudget:
    """Lines left for a second, and the count of those left out."""

    __slots__ = ("_per_s", "left", "left_out", "until_ns")

    def __init__(self, per_s: int) -> None:
        self._per_s = per_s
        self.left = per_s
        """Number of lines that may still be written."""
        self.left_out = 0
        """Number of lines that were too many."""
        self.until_ns = 0
        """Start of the next second, on the monotonic clock."""

    def renew(self, now_ns: int) -> str:
        """Begin a new second if it is time.

        Returns:
            A line that says how many lines the last second left out; empty for none.
        """
        if now_ns < self.until_ns:
            return ""
        self.until_ns = now_ns + _NS_PER_S
        self.left = self._per_s
        return self.settle()

    def settle(self) -> str:
        """Return a line that says how many lines were left out, and forget them."""
        text = f"... {self.left_out} more lines" if self.left_out else ""
        self.left_out = 0
        return text
