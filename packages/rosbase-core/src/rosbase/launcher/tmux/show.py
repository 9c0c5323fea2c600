"""Show a run in its panes: each has the output of its program, and gets the news of it."""

import logging
from collections.abc import Callable, Sequence

from rosbase.launcher.fleet import Entry
from rosbase.launcher.tmux.panes import Panes
from rosbase.text.printable import log_line

__all__ = ["PaneShow"]

_PERIOD_S = 0.5
_RED, _PLAIN = "\x1b[31m", "\x1b[0m"


class PaneShow:
    """Writes news into the panes, and ends the script of a pane whose program has ended."""

    period_s: float | None = _PERIOD_S

    def __init__(self, panes: Panes) -> None:
        """Show in these panes."""
        self._panes = panes
        self._over: dict[str, int] = {}

    def output(self, key: str, text: str, *, is_error: bool) -> None:
        """Do nothing: the pane shows it."""

    def say(self, key: str, level: int, text: str) -> None:
        """Write a line into the pane of a program."""
        line = f"[rosbase] {log_line(text)}"
        self._panes.write(key, f"{_RED}{line}{_PLAIN}" if level >= logging.ERROR else line)

    def changed(self, entry: Entry) -> None:
        """Write the news, and remember an end."""
        if entry.state in ("waiting", "restarting") and entry.detail:
            self.say(entry.key, logging.INFO, f"{entry.state} {entry.detail}")
        if entry.state in ("ended", "failed", "stopped"):
            self._over[entry.key] = entry.status or 0
        else:
            self._over.pop(entry.key, None)

    def refresh(self, entries: Sequence[Entry], pid_of: Callable[[str], int | None]) -> None:
        """End the scripts in the panes of the programs that have ended."""
        while self._over:
            key, status = self._over.popitem()
            self._panes.finish(key, status)

    def end(self) -> None:
        """Leave the panes as they are, once each shows the status of its program."""
        self._panes.drain()
