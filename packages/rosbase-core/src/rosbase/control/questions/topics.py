"""Questions about topics."""

from __future__ import annotations

from rosbase.control.gathering import ask_one
from rosbase.control.joined_topics import joined_topics
from rosbase.control.questions.base import Questions, label
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from typing import Any

    from rosbase.control.buses import Bus
    from rosbase.control.shapes import Count, Process, Topic
    from rosbase.control.watching import Heard, Watch

__all__ = ["TopicQuestions"]


class TopicQuestions(Questions):
    """Questions about topics: which there are, and what is published."""

    def topics(self) -> list[Topic]:
        """Return the topics of all programs, by name, each with its ends in all of them."""
        found = [(pid, answer["topics"]) for pid, answer in self._gather("topic.list")]
        return list(joined_topics(found).values())

    def topic(self, name: str) -> Topic:
        """Return a topic; the slash in front may be left out.

        Raises:
            ControlError: No program has it.
        """
        topics = {topic["name"]: topic for topic in self.topics()}
        full = name if name in topics else f"/{name.lstrip('/')}"
        if full not in topics:
            # Only after a mistake.
            from rosbase.control.names import unknown

            raise self._explained(unknown("topic", name, topics), topics)
        return topics[full]

    def buses_of(self, topic: Topic) -> list[Bus]:
        """Return the groups of programs that carry a topic, and hear nothing of each other."""
        from rosbase.control.buses import buses, on_several

        return on_several(topic, buses(self.processes()))

    def echo(
        self,
        topic: str,
        *,
        limit: int = 100,
        every_s: float = 0.0,
        timeout_s: float | None = None,
    ) -> Iterator[Heard]:
        """Yield the messages of a topic, as they are published.

        Args:
            topic: Its name.
            limit: How many messages the program keeps for a slow reader; older ones are dropped
                and counted.
            every_s: Leave out messages that come earlier than this after the last one, in seconds.
            timeout_s: End after this time, in seconds.

        Raises:
            ControlError: No program has the topic, or several that do not hear each other.
        """
        arguments = {"limit": limit, "every_ns": int(every_s * 1e9)}
        watch = self.watch("topic.echo", topic, arguments)
        try:
            yield from watch.heard(timeout_s)
        finally:
            watch.close()

    def count(
        self, topic: str, *, every_s: float = 1.0, measures: Iterable[str] = ("interval",)
    ) -> Iterator[Count]:
        """Yield how many messages were published, at intervals; the publishing process counts.

        Args:
            topic: Its name.
            every_s: Time between two reports, in seconds.
            measures: What else is measured: `interval`, `bytes` and `delay`.

        Raises:
            ControlError: As from `echo`, or several programs publish the topic.
        """
        arguments = {"every_ns": int(every_s * 1e9), "with": list(measures)}
        watch = self.watch("topic.count", topic, arguments, only_one=True)
        try:
            for event, _ in watch.events(None):
                yield event
        finally:
            watch.close()

    def watch(
        self, ask: str, name: str, arguments: dict[str, Any], *, only_one: bool = False
    ) -> Watch:
        """Watch a topic where each of its messages is seen once.

        Raises:
            ControlError: No program has it, or there are several places and no way to choose.
        """
        from rosbase.control.watching import Watch

        topic = self.topic(name)
        processes = self.processes()
        places = self._places(topic, processes)
        if only_one and len(places) > 1:
            raise _several(topic, processes, places)
        return Watch(places, ask, {"topic": topic["name"], **arguments})

    def _places(self, topic: Topic, processes: list[Process]) -> list[int]:
        """Return the processes in which to watch a topic."""
        from rosbase.control.buses import buses, observers, on_several

        found = on_several(topic, buses(processes))
        publishing = [bus for bus in found if bus.pids & {e["pid"] for e in topic["publishers"]}]
        chosen = publishing or found
        if len(chosen) > 1:
            raise _several(topic, processes, [min(bus.pids) for bus in chosen])
        if not chosen:
            raise ControlError(f"the program of topic {topic['name']} has ended", "unknown")
        return observers(topic, chosen[0])

    def topic_type(self, name: str, pid: int | None = None) -> dict[str, Any]:
        """Return the type of a topic with its schema, as the program tells it.

        Raises:
            ControlError: No program has the topic.
        """
        if pid is None:
            topic = self.topic(name)
            name, pid = topic["name"], [*topic["publishers"], *topic["subscriptions"]][0]["pid"]
        answer: dict[str, Any] = ask_one(pid, "topic.type", {"topic": name})[0]
        return answer


def _several(topic: Topic, processes: list[Process], pids: list[int]) -> ControlError:
    """Return the error for a topic of programs that do not hear each other."""
    from rosbase.control.names import ambiguous

    who = [label(process) for process in processes if process["pid"] in pids]
    return ambiguous("topic", topic["name"], who)
