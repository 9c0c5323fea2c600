"""Answers about topics: which there are, what is on them, and a publisher for clients."""

from typing import Any

from rosbase.contracts.graph import TopicEnd
from rosbase.control.answers.ends import (
    all_graphs,
    find_class,
    find_topic,
    find_topics,
    format_facts,
    format_of,
)
from rosbase.control.answers.topic_count import TopicCount
from rosbase.control.answers.topic_counts import TopicCounts
from rosbase.control.answers.topic_echo import TopicEcho
from rosbase.control.answers.topic_publish import publish
from rosbase.control.requests import Answerer, Request
from rosbase.control.session import Session
from rosbase.errors import ControlError
from rosbase.qos import QoSProfile

__all__ = ["ANSWERS", "end_facts"]

_MOST_WAITING = 10_000
_LEAST_EVERY_NS = 10_000_000
_EVERY_NS = 1_000_000_000


def _list(_: Session, __: Request) -> dict[str, Any]:
    topics: dict[tuple[str, str], dict[str, Any]] = {}
    for _program, _backend, graph in all_graphs():
        for kind, ends in (
            ("publishers", graph.publishers),
            ("subscriptions", graph.subscriptions),
        ):
            for end in ends:
                topic = topics.setdefault(
                    (end.name, end.type_name),
                    {
                        "name": end.name,
                        "type": end.type_name,
                        "publishers": [],
                        "subscriptions": [],
                    },
                )
                topic[kind].append(end_facts(end))
    return {"topics": [topics[key] for key in sorted(topics)]}


def end_facts(end: TopicEnd) -> dict[str, Any]:
    """Return what is told of a publisher or a subscription."""
    facts: dict[str, Any] = {"node": end.node, "qos": _qos(end.profile)}
    if end.dropped is not None:
        facts["dropped"] = end.dropped
    return facts


def _qos(profile: QoSProfile | None) -> dict[str, Any] | None:
    if profile is None:
        return None
    return {
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
        "history": profile.history.name.lower(),
        "depth": profile.depth,
    }


def _type(_: Session, request: Request) -> dict[str, Any]:
    name = request.text("topic", "")
    if name:
        topic = find_topic(name)
        return format_facts(format_of(topic.backend, topic.type_name, topic.msg_type))
    type_name = request.text("type")
    backend, kind = find_class(type_name)
    return format_facts(format_of(backend, type_name, kind))


def _echo(session: Session, request: Request) -> TopicEcho:
    topic = find_topic(request.text("topic"))
    form = format_of(topic.backend, topic.type_name, topic.msg_type)
    limit = min(request.whole("limit", 100, 1), _MOST_WAITING)
    stream = TopicEcho(form, limit, request.whole("every_ns", 0), session.now_ns)
    stream.open(topic)
    return stream


def _count(session: Session, request: Request) -> TopicCount | TopicCounts:
    names = request.texts("topics")
    if names is not None:
        every_ns = request.whole("every_ns", _EVERY_NS, _LEAST_EVERY_NS)
        return TopicCounts(find_topics(names), every_ns, session.now_ns)
    topic = find_topic(request.text("topic"))
    wanted = set(request.texts("with") or ["interval"])
    if wrong := wanted - {"interval", "bytes", "delay"}:
        raise ControlError(f"with has no {sorted(wrong)[0][:100]!r}", "invalid")
    needs_format = wanted & {"bytes", "delay"}
    form = format_of(topic.backend, topic.type_name, topic.msg_type) if needs_format else None
    every_ns = request.whole("every_ns", _EVERY_NS, _LEAST_EVERY_NS)
    stream = TopicCount(topic.type_name, form, wanted, every_ns, session.now_ns)
    stream.open(topic)
    return stream


ANSWERS: dict[str, Answerer] = {
    "topic.list": _list,
    "topic.type": _type,
    "topic.echo": _echo,
    "topic.count": _count,
    "topic.publish": publish,
}
