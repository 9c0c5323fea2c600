"""Publish on topics of running programs."""

from __future__ import annotations

from rosbase.control.gathering import ask_one, connect_to
from rosbase.control.names import full_type
from rosbase.control.questions.topics import TopicQuestions
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

__all__ = ["Publication", "PublishQuestions"]


class Publication:
    """A publisher within a running program. It lives until it is closed."""

    def __init__(
        self, pid: int, topic: str, message_type: str | None, qos: Mapping[str, Any]
    ) -> None:
        from rosbase.wire.plain import decoder, encoder

        self._connection = connect_to(pid)
        try:
            which = {"topic": topic}
            if message_type is not None:
                which = {"type": full_type(message_type)}
            found, _ = self._connection.ask("topic.type", which, wait_s=5.0)
        except BaseException:
            self._connection.close()
            raise
        self.topic = topic
        self.pid = pid
        self.type: str = found["type"]
        self.schema: str = found["schema"]
        self._qos = dict(qos)
        self._encode = encoder(self.type, self.schema, _now_ns)
        self.decode = decoder(self.type, self.schema)
        """Returns the fields of a message in CDR."""

    def __enter__(self) -> Publication:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def encode(self, values: Mapping[str, Any] | None) -> bytes:
        """Return a message as CDR.

        Args:
            values: Its fields; those left out have their defaults. `now` is the time of day, and
                `auto` a header of that time.

        Raises:
            TypeError: A field has a value of the wrong kind.
            ValueError: There is an unknown field, or a value is out of the range of its field.
        """
        return self._encode(values)

    def publish(self, values: Mapping[str, Any] | None = None) -> int:
        """Publish a message; return the number of subscriptions of the program that it reaches.

        Raises:
            ControlError: The program has ended, or refuses.
            TypeError: As from `encode`.
            ValueError: As from `encode`.
        """
        return self.publish_encoded(self.encode(values))

    def publish_encoded(self, data: bytes) -> int:
        """Publish a message that is CDR already, as `publish` does."""
        arguments: dict[str, Any] = {"topic": self.topic, "type": self.type}
        if self._qos:
            arguments["qos"] = self._qos
        answer, _ = self._connection.ask("topic.publish", arguments, data, wait_s=6.0)
        return int(answer["subscriptions"])

    def close(self) -> None:
        """End the publisher. May be called repeatedly."""
        self._connection.close()


class PublishQuestions(TopicQuestions):
    """Publishing on topics."""

    def publisher(
        self, topic: str, message_type: str | None = None, *, qos: Mapping[str, Any] | None = None
    ) -> Publication:
        """Return a publisher within the program that has the topic. Use it in a `with` block.

        Args:
            topic: Its name.
            message_type: Type of the messages, such as `std_msgs/msg/String`; by default that of
                the topic.
            qos: What differs from the usual profile: `reliability`, `durability`, `depth`.

        Raises:
            ControlError: No program has the topic, or several that do not hear each other.
        """
        full, pid = self.place_of(topic)
        return Publication(pid, full, message_type, qos or {})

    def place_of(self, name: str) -> tuple[str, int]:
        """Return the full name of a topic, and the program in which to publish on it.

        Where subscriptions are, messages are delivered without a way.

        Raises:
            ControlError: As from `publisher`.
        """
        if self._program is not None:
            # In the chosen program, a topic may be new.
            return f"/{name.lstrip('/')}", self._only_pid()
        topic = self.topic(name)
        found = self.buses_of(topic)
        subscribed = {end["pid"] for end in topic["subscriptions"]}
        hearing = [bus for bus in found if bus.pids & subscribed] or found
        if len(hearing) > 1:
            from rosbase.control.names import ambiguous

            labels = self._labels()
            who = [labels[min(bus.pids)] for bus in hearing]
            raise ambiguous("topic", topic["name"], who)
        if not hearing:
            raise ControlError(f"the program of topic {topic['name']} has ended", "unknown")
        ends = {end["pid"] for end in [*topic["publishers"], *topic["subscriptions"]]}
        there = hearing[0].pids & (subscribed or ends)
        return topic["name"], min(there)

    def type_known_to(self, pid: int, message_type: str) -> dict[str, Any]:
        """Return a type with its schema, as a program knows it.

        Raises:
            ControlError: It does not know the type.
        """
        found: dict[str, Any] = ask_one(pid, "topic.type", {"type": full_type(message_type)})[0]
        return found

    def _only_pid(self) -> int:
        chosen = self._chosen() or []
        running = {process["pid"] for process in self.processes()}
        for pid in chosen:
            if pid in running:
                return pid
        raise self._not_running()


def _now_ns() -> int:
    from rosbase.clock import SystemClock

    return SystemClock().now_ns()
