"""Records of a node in its own process, as lines for the log; bounded as its output is."""

import logging
from collections.abc import Iterator

from rosbase.processes.budget import LineBudget

__all__ = ["RecordLines"]

_MAX_TEXT = 65_536


class RecordLines:
    """Splits records into lines, and limits their number.

    A line that is too long is cut, and lines beyond the limit per second are left out; the log
    says both. Errors have their own limit, so that a flood of other records does not hide
    them.
    """

    def __init__(self, max_line: int = 4096, max_lines_per_s: int = 500) -> None:
        """Start without records. The limits are characters per line and lines per second."""
        self._max_line = max_line
        self._usual, self._errors = LineBudget(max_lines_per_s), LineBudget(max_lines_per_s)

    def take(self, level: int, text: str, now_ns: int) -> Iterator[tuple[int, str]]:
        """Take a record that came at `now_ns` (monotonic); return level and text of lines."""
        budget = self._errors if level >= logging.ERROR else self._usual
        if left_out := budget.renew(now_ns):
            yield level, left_out
        for line in self._lines(text):
            if not budget.left:
                budget.left_out += 1
            else:
                budget.left -= 1
                yield level, line

    def finish(self) -> Iterator[tuple[int, str]]:
        """Return the counts of left-out lines, when no more records come."""
        for level, budget in ((logging.INFO, self._usual), (logging.ERROR, self._errors)):
            if left_out := budget.settle():
                yield level, left_out

    def _lines(self, text: str) -> Iterator[str]:
        for line in text[:_MAX_TEXT].splitlines() or [""]:
            cut = len(line) - self._max_line
            yield line if cut <= 0 else f"{line[: self._max_line]} ... {cut} more characters"
        if len(text) > _MAX_TEXT:
            yield f"... {len(text) - _MAX_TEXT} more characters"
