"""Which streams of messages the clients need. Pure."""

from collections.abc import Mapping
from typing import Any

from attrs import frozen

from rosbase.control.buses import buses, observers, on_several
from rosbase_view.attached.wanted import Question, Tag
from rosbase_view.reports import Survey, TopicKey

__all__ = ["MOST_WAITING", "TURN_EVERY_NS", "Listened", "wanted"]

MOST_WAITING = 10_000
"""Messages of a topic that wait in the program, if there is room for their bytes."""
TURN_EVERY_NS = 20_000_000
"""Time between two transforms of an Imu: a drawing that turns needs no more."""


@frozen
class Listened:
    """Topics to which clients listen."""

    topics: Mapping[TopicKey, int]
    """Topics, each with how many clients have begun to listen so far."""
    turned: frozenset[TopicKey]
    """Topics of Imus of which transforms are made."""


def wanted(survey: Survey, listened: Listened) -> dict[Tag, Question]:
    """Return the streams for the topics that clients listen to."""
    heard, turned = listened.topics, listened.turned
    found: dict[Tag, Question] = {}
    all_buses = buses(survey.processes)
    for key in {*heard, *turned} & set(survey.topics):
        topic = survey.topics[key]
        for bus in on_several(topic, all_buses):
            if min(bus.pids) != key[1]:
                continue
            for pid in observers(topic, bus):
                if key in heard:
                    arguments = {"topic": topic["name"], "limit": MOST_WAITING}
                    if _is_kept(topic):
                        # A stream begins with the messages that the program keeps. So another
                        # client gets them with another stream. The program ignores this argument.
                        arguments["listeners"] = heard[key]
                    found[Tag("echo", key, pid)] = Question("topic.echo", arguments)
                if key in turned:
                    found[Tag("transform", key, pid)] = Question(
                        "topic.echo",
                        {"topic": topic["name"], "limit": 1, "every_ns": TURN_EVERY_NS},
                    )
    return found


def _is_kept(topic: Mapping[str, Any]) -> bool:
    """Return whether a publisher keeps its messages for those who come later."""
    profiles = [end["qos"] for end in topic["publishers"]]
    return any(one is not None and one["durability"] == "transient_local" for one in profiles)
