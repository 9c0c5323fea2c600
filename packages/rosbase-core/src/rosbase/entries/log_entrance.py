"""Where log records of other threads come into a recorded program, so that a replay says them."""

import logging
from collections.abc import Callable
from functools import partial

from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind
from rosbase.entries.script import Entry
from rosbase.logger import RosbaseLogger
from rosbase.logger.dates import date_by, hear_only
from rosbase.logger.observer import add_observer, remove_observer
from rosbase.logger.record_text import whole_text
from rosbase.messages import Time
from rosbase.messages.rcl_interfaces import Log
from rosbase.wire import reader, writer

__all__ = ["LogEntrance"]

_NS_PER_S = 1_000_000_000
_MOST_LEVEL = 255
_OURS = "rosbase."


class LogEntrance:
    """Hears the records of the process while a program is recorded or replayed."""

    def __init__(self, conductor: Conductor, log_now_ns: Callable[[], int]) -> None:
        """Hear nothing yet.

        Args:
            conductor: The conductor.
            log_now_ns: Returns the date for a record, on any thread.
        """
        self._conductor = conductor
        self._log_now_ns = log_now_ns
        self._encode, self._decode = writer(Log), reader(Log)
        conductor.register(Kind.LOG, self._replay)

    def begin(self) -> None:
        """Date all records by the clock of the program, and hear them."""
        date_by(self._log_now_ns)
        if self._conductor.is_replay:
            # The lines of other threads come from the recording.
            hear_only(lambda: self._conductor.is_inside)
        else:
            add_observer(self._hear)

    def end(self) -> None:
        """Hear nothing more. Do nothing if it has ended."""
        remove_observer(self._hear)
        hear_only(None)
        date_by(None)

    def _hear(self, record: logging.LogRecord) -> None:
        # Lines of the thread inside come by themselves.
        if not self._conductor.is_inside:
            payload = partial(self._encode, _message(record))
            self._conductor.come_in(Kind.LOG, (), payload, _nothing)

    def _replay(self, entry: Entry) -> None:
        heard = self._decode(entry.payload)
        name, place = heard.name.removeprefix(_OURS), (heard.file, heard.line, heard.function)
        RosbaseLogger(name)._say_again(heard.stamp.nanoseconds, heard.level, heard.msg, place)


def _message(record: logging.LogRecord) -> Log:
    seconds = int(record.created)
    ns = seconds * _NS_PER_S + round((record.created - seconds) * _NS_PER_S)
    return Log(
        Time.as_stamp(ns),
        min(max(record.levelno, 0), _MOST_LEVEL),
        record.name,
        whole_text(record),
        record.pathname,
        record.funcName or "",
        record.lineno,
    )


def _nothing() -> None:
    """Do nothing: the record has gone where it goes."""
