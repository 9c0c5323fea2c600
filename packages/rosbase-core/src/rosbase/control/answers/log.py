"""The log of a process: the last records, and those that come."""

import logging
from collections import deque
from typing import Any

from rosbase.control.recent_log import MOST_RECORDS, Line, recent_log
from rosbase.control.requests import Answerer, Request
from rosbase.control.session import Session
from rosbase.control.streams import Stream
from rosbase.errors import ControlError
from rosbase.logger import level_number

__all__ = ["ANSWERS"]


class _LogStream(Stream):
    """Records as events."""

    def __init__(self, level: int, last: int, *, follows: bool) -> None:
        self._level = level
        if follows:
            recent_log.follow(self.wake)
        lines = recent_log.after(0)
        self._seen = lines[-1][0] if lines else recent_log.count
        passing = [line for line in lines if line[2] >= level]
        self._waiting: deque[Line] = deque(passing[len(passing) - min(last, len(passing)) :])
        self._follows = follows
        self.ok = {"count": len(self._waiting)}

    def take(self) -> tuple[dict[str, Any], bytes] | None:
        if not self._waiting and self._follows:
            self._refill()
        if not self._waiting:
            if not self._follows:
                self.end("done")
            return None
        _, stamp_ns, level, name, text = self._waiting.popleft()
        event = {"stamp_ns": stamp_ns, "level": level, "name": name, "text": text}
        if self.dropped:
            event["dropped"] = self.dropped
        return event, b""

    def close(self) -> None:
        recent_log.unfollow(self.wake)

    def _refill(self) -> None:
        lines = recent_log.after(self._seen)
        if lines:
            # What has left the memory before it was sent.
            self.dropped += max(0, lines[0][0] - self._seen - 1)
            self._seen = lines[-1][0]
            self._waiting.extend(line for line in lines if line[2] >= self._level)


def _log(_: Session, request: Request) -> Stream:
    level = request.arguments.get("level", logging.NOTSET)
    if type(level) not in (int, str):
        raise ControlError("level is a number or a name", "invalid")
    try:
        number = level_number(level)
    except ValueError as error:
        raise ControlError(str(error), "invalid") from error
    last = request.whole("last", MOST_RECORDS)
    return _LogStream(number, last, follows=request.flag("follow", default=False))


ANSWERS: dict[str, Answerer] = {"log": _log}
