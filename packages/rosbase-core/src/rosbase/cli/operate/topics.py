"""`rosbase topic list`, `info`, `type` and `find`."""

from __future__ import annotations

import sys

from rosbase.control.names import full_type, is_hidden
from rosbase.control.questions.topics import TopicQuestions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable
    from typing import Any

    from rosbase.control.buses import Bus
    from rosbase.control.shapes import Endpoint, Process, Topic

__all__ = ["find", "show_info", "show_list", "show_type"]

_MOST_NAMED = 5


def show_list(given: Any) -> None:
    """Print the names of the topics, one a line, as `ros2 topic list` does."""
    questions = TopicQuestions(given.program)
    topics = [t for t in questions.topics() if given.all or not is_hidden(t["name"])]
    if given.count_topics:
        print(len(topics))
    elif given.verbose:
        print(_verbose(topics, "Published", "publisher"))
        print(_verbose(topics, "Subscribed", "subscriber"))
    else:
        for topic in topics:
            print(topic["name"] + (f" [{', '.join(topic['types'])}]" if given.show_types else ""))
    if any(_is_in_several(topic) for topic in topics):
        _warn_of_several(questions, topics)


def _verbose(topics: list[Topic], what: str, end: str) -> str:
    lines = [f"{what} topics:"]
    for topic in topics:
        number = len(topic["publishers" if end == "publisher" else "subscriptions"])
        if number:
            types = ", ".join(topic["types"])
            lines.append(f" * {topic['name']} [{types}] {number} {end}{'s' if number > 1 else ''}")
    return "\n".join([*lines, ""])


def _is_in_several(topic: Topic) -> bool:
    return len({end["pid"] for end in [*topic["publishers"], *topic["subscriptions"]]}) > 1


def _warn_of_several(questions: TopicQuestions, topics: list[Topic]) -> None:
    """Say on stderr which topics are two topics of one name, because no bus joins them."""
    from rosbase.control.buses import buses, on_several

    processes = questions.processes()
    all_buses = buses(processes)
    by_place: dict[str, list[str]] = {}
    for topic in topics:
        if len(found := on_several(topic, all_buses)) > 1:
            names = ", ".join(_bus_name(bus, processes) for bus in found)
            by_place.setdefault(names, []).append(topic["name"])
    for names, those in by_place.items():
        shown = ", ".join(those[:_MOST_NAMED]) + (", ..." if len(those) > _MOST_NAMED else "")
        print(f"rosbase: not the same topic in each of {names}: {shown}", file=sys.stderr)


def show_info(given: Any) -> None:
    """Print the type of a topic and its numbers of ends, in all and in each program."""
    questions = TopicQuestions(given.program)
    topic = questions.topic(given.topic)
    types = topic["types"]
    # `ros2` separates the parts of the long form.
    print(f"Type: {types[0] if len(types) == 1 else types}", end="\n\n" if given.verbose else "\n")
    if given.verbose:
        _show_ends(questions, topic)
    else:
        print(f"Publisher count: {len(topic['publishers'])}")
        print(f"Subscription count: {len(topic['subscriptions'])}\n")
    processes = questions.processes()
    _show_programs(topic, processes)
    from rosbase.control.buses import buses, on_several

    _show_gap(topic, on_several(topic, buses(processes)), processes)


def _show_programs(topic: Topic, processes: list[Process]) -> None:
    from rosbase.control.questions.base import label

    for process in processes:
        parts = []
        for what, ends in (("publishes", topic["publishers"]),
                           ("subscribes", topic["subscriptions"])):  # fmt: skip
            nodes = dict.fromkeys(end["node"] for end in ends if end["pid"] == process["pid"])
            if nodes:
                parts.append(f"{what} ({', '.join(nodes)})")
        if parts:
            print(f"{label(process)}, {_backend(process)}: {', '.join(parts)}")


def _show_gap(topic: Topic, found: list[Bus], processes: list[Process]) -> None:
    """Say which programs have the topic and do not hear each other, and what to do."""
    if len(found) < 2:
        return
    publishing = {end["pid"] for end in topic["publishers"]}
    hearing = {end["pid"] for end in topic["subscriptions"]}
    for bus in found:
        others = [other for other in found if other is not bus and other.pids & publishing]
        if bus.pids & hearing and others:
            names = ", ".join(_bus_name(other, processes) for other in others)
            print(f"Not connected: {_bus_name(bus, processes)} does not hear {names}")
    print(_how_to_join(found))


def _how_to_join(apart: list[Bus]) -> str:
    if all(bus.backend == "ros2" for bus in apart):
        domains = ", ".join(bus.network for bus in apart)
        return f"The programs are in different ROS domains: {domains}. Give them one ROS_DOMAIN_ID."
    return (
        "The backend local joins the nodes of one program. To join programs, run each of them "
        "with ROSBASE_BACKEND=ros2."
    )


def _bus_name(bus: Bus, processes: Iterable[Process]) -> str:
    from rosbase.control.questions.base import label

    return " + ".join(label(process) for process in processes if process["pid"] in bus.pids)


def _backend(process: Process) -> str:
    return next((p["backend"] for p in process["programs"] if p["backend"]), "local")


def _show_ends(questions: TopicQuestions, topic: Topic) -> None:
    """Print each end with its quality of service, as `ros2 topic info --verbose` does."""
    hashes = {
        pid: questions.topic_type(topic["name"], pid)
        for pid in {end["pid"] for end in [*topic["publishers"], *topic["subscriptions"]]}
    }
    for title, kind, ends in (
        ("Publisher count", "PUBLISHER", topic["publishers"]),
        ("Subscription count", "SUBSCRIPTION", topic["subscriptions"]),
    ):
        print(f"{title}: {len(ends)}\n")
        for end in ends:
            print(_end_text(end, kind, hashes[end["pid"]]))


def _end_text(end: Endpoint, kind: str, of_type: dict[str, Any]) -> str:
    namespace, _, node = end["node"].rpartition("/")
    # A backend of a plugin may not know it.
    qos = end["qos"] or {
        "reliability": "unknown", "durability": "unknown", "history": "unknown", "depth": 0
    }  # fmt: skip
    history = qos["history"].upper()
    if history == "KEEP_LAST":
        history = f"{history} ({qos['depth']})"
    dropped = f"Dropped: {end['dropped']}\n" if end.get("dropped") else ""
    return (
        f"Node name: {node}\nNode namespace: {namespace or '/'}\nTopic type: {of_type['type']}\n"
        f"Topic type hash: {of_type['hash']}\nEndpoint type: {kind}\nProcess: {end['pid']}\n"
        f"{dropped}QoS profile:\n  Reliability: {qos['reliability'].upper()}\n"
        f"  History (Depth): {history}\n  Durability: {qos['durability'].upper()}\n"
    )


def show_type(given: Any) -> None:
    """Print the type of a topic."""
    for name in TopicQuestions(given.program).topic(given.topic)["types"]:
        print(name)


def find(given: Any) -> None:
    """Print the names of the topics of a type."""
    topics = TopicQuestions(given.program).topics()
    found = [topic["name"] for topic in topics if full_type(given.type) in topic["types"]]
    if given.count_topics:
        print(len(found))
    for name in [] if given.count_topics else found:
        print(name)
