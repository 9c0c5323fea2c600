"""What has come and was not taken yet: bounded, however slow the view is."""

import threading
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from attrs import frozen

from rosbase import WireError
from rosbase.control.joined_log import Repeats
from rosbase.control.shapes import LogRecord
from rosbase.wire.plain import decoder
from rosbase_view.attached.wanted import Tag
from rosbase_view.known import MOST_RECORDS
from rosbase_view.reports import (
    Counted,
    Heard,
    Logged,
    NodeReport,
    Report,
    Said,
    Survey,
    TopicKey,
)

__all__ = ["Inbox"]


@frozen
class _Echo:
    """A message that nobody has read yet."""

    topic: TopicKey
    answer: Mapping[str, Any]
    event: Mapping[str, Any]
    data: bytes


class Inbox:
    """Takes reports and events from any thread. One thread takes them out."""

    def __init__(self) -> None:
        """Begin empty."""
        self._lock = threading.Lock()
        self._survey: Survey | None = None
        self._node: NodeReport | None = None
        self._said: Said | None = None
        self._echo: _Echo | None = None
        # Messages and seconds of each topic, in each process that counts it.
        self._counts: dict[TopicKey, dict[int, tuple[int, float]]] = {}
        self._records: deque[LogRecord] = deque(maxlen=MOST_RECORDS)
        self._repeats = Repeats([])
        self._decoders: dict[tuple[str, str], Callable[[bytes], dict[str, Any]]] = {}

    def put(self, report: Survey | NodeReport | Said) -> None:
        """Take a report in place of the one before."""
        with self._lock:
            if isinstance(report, Survey):
                self._survey = report
            elif isinstance(report, NodeReport):
                self._node = report
            else:
                self._said = report

    def put_event(
        self, tag: Tag, answer: Mapping[str, Any], event: Mapping[str, Any], data: bytes
    ) -> None:
        """Take an event of a stream."""
        with self._lock:
            if tag.kind == "count":
                window = event["window"]
                topic = self._counts.setdefault(tag.topic, {})
                count, seconds = topic.get(tag.pid, (0, 0.0))
                topic[tag.pid] = count + window["count"], seconds + window["seconds"]
            elif tag.kind == "echo":
                self._echo = _Echo(tag.topic, answer, event, data)
            else:
                record: Any = {**event, "pid": tag.pid}
                self._records.append(record)

    def take(self) -> list[Report]:
        """Return all reports since the last call, a survey first."""
        with self._lock:
            survey, node, said = self._survey, self._node, self._said
            echo, counts, records = self._echo, self._counts, list(self._records)
            self._survey = self._node = self._said = self._echo = None
            self._counts = {}
            self._records.clear()
        found: list[Report] = []
        if survey is not None:
            self._repeats.add(survey.processes)
            found.append(survey)
        for topic, parts in counts.items():
            total = sum(count for count, _ in parts.values())
            found.append(Counted(topic, total, max(seconds for _, seconds in parts.values())))
        if new := self._without_repeats(records):
            found.append(Logged(new))
        if echo is not None:
            found.append(self._read(echo))
        return [*found, *(one for one in (node, said) if one is not None)]

    def _without_repeats(self, records: list[LogRecord]) -> list[LogRecord]:
        """Return the records in the order of time, without those that a manager repeats."""
        records.sort(key=lambda record: record["stamp_ns"])
        return [record for record in records if not self._repeats.has(record)]

    def _read(self, echo: _Echo) -> Report:
        key = echo.answer["type"], echo.answer["schema"]
        try:
            decode = self._decoders.get(key)
            if decode is None:
                decode = self._decoders[key] = decoder(*key)
            message = decode(echo.data)
        except WireError as error:
            return Said(f"cannot read {echo.topic[0]}: {error}", is_error=True)
        event = echo.event
        return Heard(echo.topic, key[0], event["stamp_ns"], message, event["dropped"])
