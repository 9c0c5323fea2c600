"""Which streams the view needs for what is shown. Pure."""

from collections.abc import Iterator, Mapping
from typing import Any, Literal, NamedTuple

from attrs import frozen

from rosbase.control.buses import Bus, buses, observers, on_several
from rosbase_view.reports import Survey, TopicKey
from rosbase_view.source import Gaze, Pace

__all__ = ["Question", "Tag", "wanted"]

_NO_TOPIC: TopicKey = ("", 0)
# A program looks at each topic for each report, which takes it a third of a microsecond.
_OFTEN_NS, _MANY, _SELDOM_NS = 100_000_000, 1_000, 500_000_000
# The names must fit into a request.
_MOST_NAMES = 200
_LAST_RECORDS = 1_000
_ECHOES = {
    Pace.NEWEST: {"limit": 1, "every_ns": 50_000_000},
    Pace.ALL: {"limit": 10_000, "every_ns": 0},
}


class Tag(NamedTuple):
    """Which stream an event belongs to."""

    kind: Literal["counts", "echo", "log", "transform"]
    topic: TopicKey
    """The topic of an echo; for counts, a number for each stream, and the pid of the keys."""
    pid: int


@frozen
class Question:
    """The request that opens a stream."""

    ask: str
    arguments: Mapping[str, Any]


def wanted(survey: Survey, gaze: Gaze) -> dict[Tag, Question]:
    """Return the streams for these programs, and for what the user looks at.

    Each message is counted where it is seen exactly once.
    """
    log = Question("log", {"level": 0, "follow": True, "last": _LAST_RECORDS})
    found = {Tag("log", _NO_TOPIC, process["pid"]): log for process in survey.processes}
    names: dict[tuple[int, int], list[str]] = {}
    for key, bus in _carried(survey):
        topic = survey.topics[key]
        for pid in observers(topic, bus):
            names.setdefault((key[1], pid), []).append(topic["name"])
            if key in gaze.topics:
                arguments = {"topic": topic["name"], **_ECHOES[gaze.pace]}
                found[Tag("echo", key, pid)] = Question("topic.echo", arguments)
    every_ns = _OFTEN_NS if len(survey.topics) <= _MANY else _SELDOM_NS
    for (first_pid, pid), topics in names.items():
        for begin in range(0, len(topics), _MOST_NAMES):
            arguments = {"topics": topics[begin : begin + _MOST_NAMES], "every_ns": every_ns}
            tag = Tag("counts", (str(begin // _MOST_NAMES), first_pid), pid)
            found[tag] = Question("topic.count", arguments)
    return found


def _carried(survey: Survey) -> Iterator[tuple[TopicKey, Bus]]:
    """Yield each topic with the processes that share it."""
    all_buses = buses(survey.processes)
    for key, topic in survey.topics.items():
        for bus in on_several(topic, all_buses):
            if min(bus.pids) == key[1]:
                yield key, bus
