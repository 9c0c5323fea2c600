"""Times of the main loops."""

from collections.abc import Hashable, Sequence
from typing import Any

from rosbase.control.shapes import Statistics
from rosbase_view.drawing.bars import filled
from rosbase_view.drawing.figures import rate, times
from rosbase_view.drawing.lines import Ink, Line, Span, clipped, line
from rosbase_view.drawing.table import Cell, Column
from rosbase_view.pages.base import BasePage
from rosbase_view.pages.page import Pane

__all__ = ["LoopPage", "coarser"]

_NUMBER = 11


class LoopPage(BasePage):
    """Programs that have a main loop."""

    title = "loop"
    detail_rows = 14
    columns = (
        Column("PROGRAM", 16, share=1),
        Column("RATE", 9, is_right=True),
        Column("PERIOD 50 %", _NUMBER, is_right=True),
        Column("99 %", _NUMBER, is_right=True),
        Column("BUSY 99 %", _NUMBER, is_right=True),
        Column("OVERRUNS", 8, is_right=True),
        Column("PERIOD MAX", _NUMBER, is_right=True),
        Column("BUSY MAX", _NUMBER, is_right=True),
        Column("TICKS", 10, is_right=True),
    )

    def keys(self) -> Sequence[tuple[str, int]]:
        """Return the programs by name and pid."""
        return sorted((one["program"], one["pid"]) for one in self.known.loops if one["period"])

    def cells(self, key: Hashable, pane: Pane) -> Sequence[Cell]:
        """Return the cells of a row."""
        one = self._loop(key)
        if one is None:
            return [Cell("")] * len(self.columns)
        period, busy = one["period"], one["busy"]
        late = Ink.WARNING if one["overruns"] else Ink.PLAIN
        return (
            Cell(one["program"].lstrip("/")),
            Cell(rate(one.get("rate_hz"))),
            Cell(times(period.get("p50"))),
            Cell(times(period.get("p99"))),
            Cell(times(busy.get("p99"))),
            Cell(str(one["overruns"]), late),
            Cell(times(period.get("max_ns"))),
            Cell(times(busy.get("max_ns"))),
            Cell(str(one["ticks"])),
        )

    def detail(self, key: Hashable | None, pane: Pane, first: int) -> list[Line]:
        """Return the histogram of the period."""
        one = None if key is None else self._loop(key)
        if one is None:
            return []
        buckets = coarser(one["period"]["histogram"], max(1, pane.height - 1))
        most = max((count for _, count in buckets), default=1)
        bar_width = max(1, pane.width - 2 * _NUMBER - 9)
        title = f"periods of {one['program'].lstrip('/')}"
        return [
            line(Span(clipped(title, pane.width), Ink.TITLE)),
            *(
                line(
                    f"up to {times(upper):>{_NUMBER}} {count:>{_NUMBER}} ",
                    Span(filled(count / most, bar_width, self.glyphs), Ink.DRAWING),
                )
                for upper, count in buckets
            ),
        ]

    def _loop(self, key: Hashable) -> Statistics | None:
        loops: Sequence[Any] = self.known.loops
        return next((one for one in loops if (one["program"], one["pid"]) == key), None)


def coarser(buckets: Sequence[Sequence[int]], most: int) -> list[tuple[int, int]]:
    """Return the buckets that have any values, joined until there are at most `most` of them."""
    used = [(upper, count) for upper, count in buckets if count]
    step = -(-len(used) // most) if used else 1
    groups = [used[begin : begin + step] for begin in range(0, len(used), step)]
    return [(group[-1][0], sum(count for _, count in group)) for group in groups]
