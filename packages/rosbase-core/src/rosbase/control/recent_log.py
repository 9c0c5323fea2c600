"""The last records of this process's loggers, in memory, for clients that come later."""

import logging
import threading
from collections import deque
from collections.abc import Callable
from typing import TypeAlias

from rosbase.logger.observer import add_observer, remove_observer
from rosbase.logger.record_text import whole_text

__all__ = ["MOST_RECORDS", "Line", "RecentLog", "recent_log"]

MOST_RECORDS = 1_000
"""Number of records that are kept."""
_MOST_TEXT = 8_192
_CUT = "\n... "
_NAME = "rosbase."

Line: TypeAlias = tuple[int, int, int, str, str]
"""Serial number, date in nanoseconds since 1970, level, logger, and text of a record."""


class RecentLog:
    """Keeps the last records. Records come on any thread; one thread reads."""

    def __init__(self) -> None:
        self.lines: deque[Line] = deque(maxlen=MOST_RECORDS)
        """The last records, the oldest first."""
        self.count = 0
        """Number of records so far, which is also the serial number of the last one."""
        self._followers: tuple[Callable[[], object], ...] = ()
        self._is_hearing = False
        # A signal handler may log while its thread does.
        self._lock = threading.RLock()

    def start(self) -> None:
        """Hear the loggers of this process from now on. Idempotent."""
        if self._is_hearing:
            return
        self._is_hearing = True
        # In a forked child, a thread that is gone may hold the one from before.
        self._lock, self._followers = threading.RLock(), ()
        add_observer(self._hear)

    def stop(self) -> None:
        """Hear them no more, and forget what was heard."""
        remove_observer(self._hear)
        self._is_hearing = False
        self.lines.clear()
        self._followers = ()

    def follow(self, function: Callable[[], object]) -> None:
        """Call the function after each record, on the thread that has logged it."""
        self._followers = (*self._followers, function)

    def unfollow(self, function: Callable[[], object]) -> None:
        """Call the function no more."""
        self._followers = tuple(one for one in self._followers if one != function)

    def after(self, serial: int) -> list[Line]:
        """Return the records in memory with a greater serial number, the oldest first."""
        found: list[Line] = []
        # A copy, because records come meanwhile. To copy is one step.
        for line in reversed(self.lines.copy()):
            if line[0] <= serial:
                break
            found.append(line)
        return found[::-1]

    def _hear(self, record: logging.LogRecord) -> None:
        text = whole_text(record)
        if len(text) > _MOST_TEXT:
            half = _MOST_TEXT // 2
            text = f"{text[:half]}{_CUT}{len(text) - 2 * half} more characters{_CUT}{text[-half:]}"
        name = record.name.removeprefix(_NAME)
        with self._lock:
            self.count += 1
            self.lines.append((self.count, _ns(record), record.levelno, name, text))
        for follower in self._followers:
            follower()


def _ns(record: logging.LogRecord) -> int:
    return int(record.created * 1e9)


recent_log = RecentLog()
"""The log of this process."""
