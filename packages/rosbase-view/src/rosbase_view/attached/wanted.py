"""Which streams the view needs for what is shown. Pure."""

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from attrs import frozen

from rosbase.control.buses import buses, observers, on_several
from rosbase_view.reports import Survey, TopicKey
from rosbase_view.source import Gaze

__all__ = ["Question", "Tag", "wanted"]

_NO_TOPIC: TopicKey = ("", 0)
# A report costs a program some tens of microseconds: all topics together send 100 a second at most.
_REPORTS_HZ = 100.0
_INTERVALS_S = (0.1, 0.2, 0.5, 1.0)
_ECHO_EVERY_NS = 50_000_000
_LAST_RECORDS = 1_000


class Tag(NamedTuple):
    """Which stream an event belongs to."""

    kind: Literal["count", "echo", "log", "transform"]
    topic: TopicKey
    pid: int


@frozen
class Question:
    """What to ask for a stream."""

    ask: str
    arguments: Mapping[str, Any]


def wanted(survey: Survey, gaze: Gaze) -> dict[Tag, Question]:
    """Return the streams for these programs, and for what the user looks at.

    Each message is counted where it is seen exactly once.
    """
    found = {
        Tag("log", _NO_TOPIC, process["pid"]): Question(
            "log", {"level": 0, "follow": True, "last": _LAST_RECORDS}
        )
        for process in survey.processes
    }
    all_buses = buses(survey.processes)
    every_ns = int(_interval_s(len(survey.topics)) * 1e9)
    for key, topic in survey.topics.items():
        for bus in on_several(topic, all_buses):
            if min(bus.pids) != key[1]:
                continue
            for pid in observers(topic, bus):
                name = {"topic": topic["name"]}
                found[Tag("count", key, pid)] = Question(
                    "topic.count", {**name, "every_ns": every_ns, "with": ["interval"]}
                )
                if key == gaze.topic:
                    found[Tag("echo", key, pid)] = Question(
                        "topic.echo", {**name, "limit": 1, "every_ns": _ECHO_EVERY_NS}
                    )
    return found


def _interval_s(topics: int) -> float:
    """Return the time between two reports. It has few values, so that streams can stay open."""
    return next((s for s in _INTERVALS_S if topics / s <= _REPORTS_HZ), _INTERVALS_S[-1])
