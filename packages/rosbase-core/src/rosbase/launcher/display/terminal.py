"""Show a run on one terminal, or write it to a pipe line by line."""

import logging
import sys
from collections.abc import Callable, Sequence

from rosbase.cli.output import Output
from rosbase.cli.panel.style import Style, style_of
from rosbase.cli.screen import Screen
from rosbase.clock import Clock
from rosbase.launcher.display.lines import Labels
from rosbase.launcher.display.table import draw_table
from rosbase.launcher.fleet import Entry
from rosbase.logger.console import wants_colour

__all__ = ["Terminal"]

_PATIENCE_S = 0.5


class Terminal:
    """Writes to stdout: output and news as lines, and below them the table of states.

    Without a terminal there is no table, and each change of state is a line.
    """

    def __init__(self, keys: Sequence[str], clock: Clock) -> None:
        """Begin without a line.

        Args:
            keys: Keys of all programs, in the order of the file.
            clock: The clock.
        """
        self._output = Output(sys.stdout)
        self._screen = Screen(self._output)
        self._clock = clock
        style = style_of(self._output.encoding)
        has_colour = wants_colour(sys.stdout) and style.has_colour
        self._style = Style(has_colour=has_colour, has_unicode=style.has_unicode)
        self._labels = Labels(keys, self._style)
        self._shown: list[str] = []

    @property
    def period_s(self) -> float | None:
        """Seconds between updates of the table; None if there is none."""
        return self._screen.period_s if self._screen.is_terminal else None

    def output(self, key: str, text: str, *, is_error: bool) -> None:
        """Write a line of a program's output."""
        self._write(self._labels.output(key, text, is_error=is_error))

    def say(self, key: str, level: int, text: str) -> None:
        """Write a line about a program."""
        self._write(self._labels.news(key, level, text))

    def changed(self, entry: Entry) -> None:
        """Write a line for a change of state, unless another line tells it."""
        text = _news_of(entry)
        if text:
            self.say(entry.key, logging.INFO, text)

    def refresh(self, entries: Sequence[Entry], pid_of: Callable[[str], int | None]) -> None:
        """Draw the table anew, on a terminal; otherwise write what has not been taken so far."""
        if not self._screen.is_terminal:
            self._output.flush()
            return
        now_ns, size = self._clock.monotonic_ns(), self._screen.size
        table = draw_table(entries, pid_of, now_ns, size, self._labels, self._style)
        if table != self._shown:
            self._shown = table
            self._screen.show(table)

    def end(self) -> None:
        """Leave the last table standing, and write what a slow reader has not taken."""
        self._screen.end()
        self._output.drain(_PATIENCE_S, self._clock)

    def _write(self, line: str) -> None:
        self._screen.above(self._output, f"{line}\n")


def _news_of(entry: Entry) -> str:
    """Return the news that a state is; the log of the processes tells how a program has ended."""
    if entry.state == "running":
        return "starting"
    if entry.state == "restarting":
        return f"restarting {entry.detail}"
    if entry.state == "waiting" and entry.detail:
        return f"waiting {entry.detail}"
    if entry.state == "stopped":
        return "" if entry.place >= 0 else "stopped before it started"
    return "stopping" if entry.state == "stopping" else ""
