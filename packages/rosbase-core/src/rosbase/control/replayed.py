"""Requests of a recording: carried out again, in a replay, by the functions that answer clients."""

from collections.abc import Callable
from typing import Any, cast

from rosbase.clock import SystemClock
from rosbase.control.answers import all_answers
from rosbase.control.answers.topic_publish import CLOSE, close_again
from rosbase.control.requests import Request
from rosbase.control.session import Session
from rosbase.entries.payloads import from_json
from rosbase.entries.script import Entry

__all__ = ["ReplayedControl"]

_CLOCK = SystemClock()


class ReplayedControl:
    """The clients of a recording, who hear no answers."""

    def __init__(self) -> None:
        self._sessions: dict[int, _ReplayedSession] = {}
        self._answers: dict[str, Callable[[Session, Request], object]] = {}

    def play(self, entry: Entry) -> None:
        """Begin to answer a request; what it queues for the main loop is an entry by itself."""
        if not self._answers:
            self._answers = {**all_answers(), CLOSE: close_again}
        line, _, data = entry.payload.partition(b"\n")
        arguments = cast("dict[str, Any]", from_json(line))
        kept = self._sessions.setdefault(entry.ints[1], _ReplayedSession(entry.ints[1]))
        # It has all that answerers use.
        session = cast("Session", kept)
        request = Request(session, 0, arguments["ask"], arguments, data)
        self._answers[request.ask](session, request)


class _ReplayedSession:
    """The part of a `Session` that answerers of recorded requests use."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.kept: dict[str, Any] = {}
        self.is_closed = False

    def now_ns(self) -> int:
        """Return the time on the machine's monotonic clock."""
        return _CLOCK.monotonic_ns()

    def call(self, function: Callable[[], object]) -> None:
        """Do nothing: later requests of the client are entries by themselves."""

    def on_close(self, function: Callable[[], object]) -> None:
        """Do nothing, as the end of the connection is an entry."""

    def answered(self, request: Request, frame: dict[str, Any], data: bytes) -> None:
        """Drop the answer."""
