"""The log of all programs."""

from collections.abc import Hashable, Sequence
from datetime import datetime
from textwrap import wrap

from rosbase.control.shapes import LogRecord
from rosbase_view.drawing.lines import Ink, Line, Span, clipped, line
from rosbase_view.drawing.table import Cell, Column
from rosbase_view.pages.base import BasePage
from rosbase_view.pages.page import Pane

__all__ = ["LogPage"]

# Numbers of `logging`, from which on a record has that name.
_LEVELS = ((50, "FATAL", Ink.BAD), (40, "ERROR", Ink.BAD), (30, "WARN", Ink.WARNING),
           (20, "INFO", Ink.PLAIN), (0, "DEBUG", Ink.DIM))  # fmt: skip


class LogPage(BasePage):
    """Records of the log; the cursor stays at the last one until it is moved."""

    title = "log"
    follows = True
    columns = (
        Column("TIME", 12),
        Column("LEVEL", 5),
        Column("NAME", 14),
        Column("TEXT", 20, share=1),
    )

    def keys(self) -> Sequence[int]:
        """Return the records by their number."""
        known = self.known
        return range(known.logged - len(known.log), known.logged)

    def cells(self, key: Hashable, pane: Pane) -> Sequence[Cell]:
        """Return the cells of a row."""
        record = self._record(key)
        level, ink = _level(record)
        return (
            Cell(_clock(record["stamp_ns"]), Ink.DIM),
            Cell(level, ink),
            Cell(record["name"], Ink.DIM),
            Cell(record["text"], ink),
        )

    def detail(self, key: Hashable | None, pane: Pane, first: int) -> list[Line]:
        """Return the whole text of the record."""
        if key is None:
            return []
        record = self._record(key)
        # A recording does not tell the process.
        place = f" [{record['pid']}]" if record["pid"] else ""
        title = f"{_level(record)[0]} of {record['name']}{place}"
        parts = [
            part
            for paragraph in record["text"].splitlines()
            for part in wrap(paragraph, max(1, pane.width)) or [""]
        ]
        text = [line(clipped(part, pane.width)) for part in parts[first:]]
        return [line(Span(clipped(title, pane.width), Ink.TITLE)), *text][: pane.height]

    def _record(self, key: Hashable) -> LogRecord:
        assert isinstance(key, int)
        return self.known.log[key - (self.known.logged - len(self.known.log))]


def _level(record: LogRecord) -> tuple[str, Ink]:
    number = int(record["level"])
    return next((name, ink) for least, name, ink in _LEVELS if number >= least)


def _clock(stamp_ns: int) -> str:
    """Return the time of day here, with milliseconds."""
    seconds, rest = divmod(stamp_ns, 1_000_000_000)
    return f"{datetime.fromtimestamp(seconds):%H:%M:%S}.{rest // 1_000_000:03d}"
