"""Reports that have come and were not taken yet: bounded, however slow the view is."""

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from attrs import evolve

from rosbase.control.joined_log import Repeats
from rosbase.control.shapes import LogRecord
from rosbase_view.attached.wanted import Tag
from rosbase_view.known import MOST_RECORDS
from rosbase_view.reports import (
    Counted,
    Heard,
    Logged,
    NodeKey,
    NodeReport,
    Report,
    Said,
    Survey,
    TopicKey,
)
from rosbase_view.source import Pace

__all__ = ["Inbox"]

_MOST_MESSAGES = 10_000
_MOST_BYTES = 64 * 1024 * 1024


class Inbox:
    """Takes reports and events from any thread. One thread takes them out."""

    def __init__(self, on_news: Callable[[], object] = lambda: None) -> None:
        """Begin empty.

        Args:
            on_news: Called when there is something to take.
        """
        self.on_news = on_news
        self.pace = Pace.NEWEST
        """Which messages are kept; set before they come."""
        self._lock = threading.Lock()
        self._survey: Survey | None = None
        self._nodes: dict[NodeKey, NodeReport] = {}
        self._said: Said | None = None
        self._messages = _Messages()
        self._counts = _Counts()
        self._records: deque[LogRecord] = deque(maxlen=MOST_RECORDS)
        self._repeats = Repeats([])

    def put(self, report: Survey | NodeReport | Said) -> None:
        """Take a report in place of the one before."""
        with self._lock:
            if isinstance(report, Survey):
                self._survey = report
            elif isinstance(report, NodeReport):
                self._nodes[report.node] = report
            else:
                self._said = report
        self.on_news()

    def put_event(
        self, tag: Tag, answer: Mapping[str, Any], event: Mapping[str, Any], data: bytes
    ) -> None:
        """Take an event of a stream."""
        with self._lock:
            if tag.kind == "counts":
                self._counts.add(tag, answer["topics"], event)
            elif tag.kind == "echo":
                self._messages.add(_heard(tag, answer, event, data), self.pace)
            else:
                record: Any = {**event, "pid": tag.pid}
                self._records.append(record)
        self.on_news()

    def take(self) -> list[Report]:
        """Return all reports since the last call, a survey first."""
        with self._lock:
            survey, nodes, said = self._survey, self._nodes, self._said
            heard, counts, records = self._messages.take(), self._counts.take(), [*self._records]
            self._survey = self._said = None
            self._nodes = {}
            self._records.clear()
        found: list[Report] = []
        if survey is not None:
            self._repeats.add(survey.processes)
            found.append(survey)
        found += counts
        if new := self._without_repeats(records):
            found.append(Logged(new))
        return [*found, *heard, *nodes.values(), *([] if said is None else [said])]

    def _without_repeats(self, records: list[LogRecord]) -> list[LogRecord]:
        """Return the records in the order of time, without those that a manager repeats."""
        records.sort(key=lambda record: record["stamp_ns"])
        return [record for record in records if not self._repeats.has(record)]


class _Counts:
    """Messages since they were last taken, of each topic in each process that counts it."""

    def __init__(self) -> None:
        # By topic and process: messages, seconds, and the age of the last one in seconds.
        self._counts: dict[TopicKey, dict[int, tuple[int, float, float]]] = {}

    def add(self, tag: Tag, names: Iterable[str], event: Mapping[str, Any]) -> None:
        had, passed_s = event["topics"], event["seconds"]
        for name in names:
            of_topic = self._counts.setdefault((name, tag.topic[1]), {})
            count, seconds, age_s = of_topic.get(tag.pid, (0, 0.0, 0.0))
            if (new := had.get(name)) is None:
                age_s += passed_s
            else:
                count, age_s = count + new["count"], new["age_ns"] / 1e9
            of_topic[tag.pid] = count, seconds + passed_s, age_s

    def take(self) -> list[Counted]:
        taken, self._counts = self._counts, {}
        return [_sum(topic, list(parts.values())) for topic, parts in taken.items()]


def _sum(topic: TopicKey, parts: list[tuple[int, float, float]]) -> Counted:
    """Return the messages of all processes that publish a topic."""
    had = [age_s for count, _, age_s in parts if count]
    return Counted(
        topic,
        sum(count for count, _, _ in parts),
        max(seconds for _, seconds, _ in parts),
        min(had, default=0.0),
    )


class _Messages:
    """Messages that nobody has taken: the newest of each topic, or as many as there is room for."""

    def __init__(self) -> None:
        self._waiting: deque[Heard] = deque()
        self._bytes = 0
        # Messages of each topic that had to make room.
        self._lost: dict[TopicKey, int] = {}

    def add(self, heard: Heard, pace: Pace) -> None:
        if pace is Pace.NEWEST:
            self._keep(one for one in self._waiting if one.topic != heard.topic)
        self._waiting.append(heard)
        self._bytes += len(heard.data)
        while len(self._waiting) > _MOST_MESSAGES or (
            self._bytes > _MOST_BYTES and len(self._waiting) > 1
        ):
            oldest = self._waiting.popleft()
            self._bytes -= len(oldest.data)
            self._lost[oldest.topic] = self._lost.get(oldest.topic, 0) + 1

    def take(self) -> list[Heard]:
        lost = self._lost
        found = [
            evolve(one, dropped=one.dropped + lost[one.topic]) if one.topic in lost else one
            for one in self._waiting
        ]
        self._keep(())
        return found

    def _keep(self, messages: Iterable[Heard]) -> None:
        self._waiting = deque(messages)
        self._bytes = sum(len(one.data) for one in self._waiting)


def _heard(tag: Tag, answer: Mapping[str, Any], event: Mapping[str, Any], data: bytes) -> Heard:
    return Heard(
        tag.topic, answer["type"], answer["schema"], event["stamp_ns"], data, event["dropped"]
    )
