"""Messages of a bag as the inputs of a program that runs in virtual time."""

from collections import deque
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from rosbase import Backend, BackendError, ConfigurationError, RosbaseLogger, TopicEnd, WireError
from rosbase.contracts.graph import type_name_of
from rosbase.entries.replaying.inputs import Input
from rosbase_mcap.bags import Bag, BagMessage

__all__ = ["TopicFeed"]

# As many messages of a topic such as /tf_static are kept for nodes that come later.
_MOST_KEPT = 100


class TopicFeed:
    """Publishes the messages of a bag in place of the program, at their times."""

    def __init__(
        self,
        bag: Bag,
        topics: tuple[str, ...],
        logger: RosbaseLogger,
        *,
        start_ns: int,
        end_ns: int | None = None,
    ) -> None:
        """Prepare.

        Args:
            bag: The bag.
            topics: Full names of its topics; none stands for those that the program subscribes to.
            logger: Says what cannot be replayed.
            start_ns: Messages from this date on are replayed, in nanoseconds since 1970. Earlier
                ones of latched topics come at the start.
            end_ns: Messages up to this date are.

        Raises:
            ConfigurationError: The bag has no such topic.
        """
        for topic in topics:
            if topic not in bag.topics:
                known = ", ".join(sorted(bag.topics)) or "none"
                raise ConfigurationError(f"no topic {topic} in this recording; there are: {known}")
        self._bag, self._logger = bag, logger
        self._chosen = frozenset(topics) or frozenset(bag.topics)
        self._has_choice = bool(topics)
        self._start_ns, self._end_ns = start_ns, end_ns
        self._feeds: dict[str, Callable[[BagMessage], object]] = {}
        # Of latched topics that nobody has subscribed to.
        self._early: dict[str, deque[BagMessage]] = {}
        self._muted: set[str] = set()

    def begin(self, backend: Backend) -> None:
        """Publish in place of the program that has this connection."""
        self._backend = backend
        for topic in sorted(self._chosen) if self._has_choice else ():
            self._take_over(topic)
        backend.new_ends.add(self._welcome)

    def inputs(self) -> Iterator[Input]:
        """Yield the messages in the order of the bag, each at its time since the start."""
        t_ns = 0
        for message in self._bag.messages(self._chosen):
            since_ns = message.log_ns - self._start_ns
            if self._end_ns is not None and message.log_ns > self._end_ns:
                continue
            if since_ns < 0 and not self._bag.topics[message.topic].is_latched:
                continue
            # Time does not go back, whatever the bag says.
            t_ns = max(t_ns, since_ns)
            yield Input(t_ns, partial(self._play, message))

    def _play(self, message: BagMessage) -> None:
        feed = self._feeds.get(message.topic)
        if feed is not None:
            feed(message)
        elif self._bag.topics[message.topic].is_latched:
            kept = self._early.setdefault(message.topic, deque(maxlen=_MOST_KEPT))
            kept.append(message)

    def _welcome(self, end: TopicEnd) -> None:
        topic = end.name
        if topic not in self._chosen:
            return
        graph = self._backend.graph()
        if topic not in self._feeds and any(one.name == topic for one in graph.subscriptions):
            self._take_over(topic)
        is_published = any(one.name == topic for one in graph.publishers)
        if topic in self._feeds and is_published and topic not in self._muted:
            self._muted.add(topic)
            self._logger.info(f"{topic} comes from the recording, and not from the program")

    def _take_over(self, topic: str) -> None:
        of = self._bag.topics[topic]
        deliver = self._backend.take_over(topic, depth=_MOST_KEPT if of.is_latched else 0)
        feed = _Feed(self._backend, of.type_name, deliver, self._logger, is_kept=of.is_latched)
        self._feeds[topic] = feed.publish
        # Within the call that creates an end: what it shall hear comes after that.
        for message in self._early.pop(topic, ()):
            self._backend.call_soon(partial(feed.publish, message))


class _Feed:
    """Publishes the messages of one topic."""

    def __init__(
        self,
        backend: Backend,
        type_name: str,
        deliver: Callable[[Any], None],
        logger: RosbaseLogger,
        *,
        is_kept: bool,
    ) -> None:
        self._backend, self._type_name, self._is_kept = backend, type_name, is_kept
        self._deliver, self._logger = deliver, logger
        self._decode: Callable[[bytes], Any] | None = None
        self._is_refused = False

    def publish(self, message: BagMessage) -> None:
        """Publish a message, if anybody knows its type."""
        if self._is_refused:
            return
        try:
            if self._decode is None:
                msg_type = self._type(message.topic)
                if msg_type is None:
                    # Nobody hears it, and nobody will.
                    return
                self._decode = self._backend.message_format(msg_type).decode
            self._deliver(self._decode(message.data))
        except (BackendError, TypeError, WireError) as error:
            self._is_refused = True
            self._logger.error(f"{message.topic} is not replayed: {error}")

    def _type(self, topic: str) -> Any:
        """Return the program's class of the messages; None if it has none, and needs none."""
        graph = self._backend.graph()
        for end in (*graph.subscriptions, *graph.publishers):
            if end.name == topic and end.msg_type is not None:
                name = type_name_of(end.msg_type)
                if name != self._type_name:
                    raise TypeError(
                        f"the program takes {name}, the recording has {self._type_name}"
                    )
                return end.msg_type
        return self._backend.find_type(self._type_name) if self._is_kept else None
