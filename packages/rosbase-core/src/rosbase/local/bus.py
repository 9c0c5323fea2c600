"""Topics within one process: a message is handed over as it is, to every subscription.

A link is a way to another process: it subscribes here to what is wanted there, and is told
what is wanted here.
"""

import threading
from collections.abc import Callable
from typing import Any, Protocol

from rosbase.errors import BackendError
from rosbase.queued_subscription import QueuedSubscription

__all__ = ["Bus", "BusLink", "LocalPublisher", "LocalSubscription", "process_bus"]


class BusLink(Protocol):
    """What a bus tells a link."""

    def audience_changed(self, topic: str, msg_type: type, depth: int) -> None:
        """Called when others than the link itself subscribe to a topic, or do so no more.

        Args:
            topic: Its full name.
            msg_type: The type of its messages.
            depth: The greatest depth that one of them asks for; 0 if there is none left.
        """
        ...


class LocalSubscription(QueuedSubscription):
    """The last messages of a topic of this process."""

    __slots__ = ("link",)

    def __init__(
        self,
        topic: str,
        callback: Callable[[Any], object],
        depth: int,
        schedule: Callable[[Callable[[], object]], None],
        link: BusLink | None = None,
    ) -> None:
        super().__init__(topic, callback, depth, schedule)
        self.link = link
        """The link that subscribes on behalf of another process, if it is one."""


class _Topic:
    """A name, its type, and who listens. Replaced tuples, so that publishing needs no lock."""

    __slots__ = ("deliveries", "msg_type", "subscriptions", "users")

    def __init__(self, msg_type: type) -> None:
        self.msg_type = msg_type
        self.subscriptions: tuple[LocalSubscription, ...] = ()
        self.deliveries: tuple[Callable[[Any], None], ...] = ()
        self.users = 0

    def set_subscriptions(self, subscriptions: tuple[LocalSubscription, ...]) -> None:
        """Replaces those who listen."""
        self.subscriptions = subscriptions
        self.deliveries = tuple(subscription.deliver for subscription in subscriptions)

    def refusal(self, name: str, message: Any) -> TypeError:
        """What to raise for a message of another type."""
        return TypeError(f"{name} takes {self.msg_type.__name__}, not {type(message).__name__}")

    def depth_for(self, link: BusLink) -> int:
        """The greatest depth that anybody but this link asks for; 0 if nobody does."""
        return max((s.depth for s in self.subscriptions if s.link is not link), default=0)


class LocalPublisher:
    """Hands messages to the subscriptions of one topic."""

    __slots__ = ("_topic", "topic")

    def __init__(self, name: str, topic: _Topic) -> None:
        self.topic = name
        self._topic: _Topic | None = topic

    def publish(self, message: Any) -> None:
        """Queues the message with every subscription. From any thread.

        Raises:
            TypeError: The message is not of the topic's type.
            BackendError: The publisher has been destroyed.
        """
        topic = self._topic
        if topic is None:
            raise BackendError(f"the publisher of {self.topic} has been destroyed")
        if not isinstance(message, topic.msg_type):
            raise topic.refusal(self.topic, message)
        for deliver in topic.deliveries:
            deliver(message)

    def close(self) -> None:
        """Nothing can be published from here on."""
        self._topic = None


class Bus:
    """All topics of a process, or of a test."""

    def __init__(self) -> None:
        self._topics: dict[str, _Topic] = {}
        self._links: tuple[BusLink, ...] = ()
        self._lock = threading.Lock()

    def add_publisher(self, name: str, msg_type: type) -> LocalPublisher:
        """A publisher of the topic with that full name.

        Raises:
            BackendError: The topic has another type.
        """
        with self._lock:
            return LocalPublisher(name, self._enter(name, msg_type))

    def add_subscription(self, subscription: LocalSubscription, msg_type: type) -> None:
        """Has the subscription receive what is published from now on.

        Raises:
            BackendError: The topic has another type.
        """
        with self._lock:
            topic = self._enter(subscription.topic, msg_type)
            topic.set_subscriptions((*topic.subscriptions, subscription))
            self._tell_links(subscription.topic, topic)

    def remove_publisher(self, publisher: LocalPublisher) -> None:
        """Ends a publisher that `add_publisher` gave."""
        publisher.close()
        with self._lock:
            self._leave(publisher.topic)

    def resize_subscription(self, subscription: LocalSubscription, depth: int) -> None:
        """Has the subscription keep the last `depth` messages from now on."""
        with self._lock:
            subscription.resize(depth)
            self._tell_links(subscription.topic, self._topics[subscription.topic])

    def remove_subscription(self, subscription: LocalSubscription) -> None:
        """Ends a subscription that `add_subscription` took."""
        subscription.close()
        with self._lock:
            topic = self._topics[subscription.topic]
            topic.set_subscriptions(tuple(s for s in topic.subscriptions if s is not subscription))
            self._tell_links(subscription.topic, topic)
            self._leave(subscription.topic)

    def add_link(self, link: BusLink) -> None:
        """Tells the link what is wanted here, now and from now on."""
        with self._lock:
            self._links = (*self._links, link)
            for name, topic in self._topics.items():
                if depth := topic.depth_for(link):
                    link.audience_changed(name, topic.msg_type, depth)

    def remove_link(self, link: BusLink) -> None:
        """Tells it no more. Its subscriptions are for itself to remove."""
        with self._lock:
            self._links = tuple(other for other in self._links if other is not link)

    def deliver_from(self, link: BusLink, name: str, message: Any) -> None:
        """Queues a message that came over the link with everybody but the link itself.

        Raises:
            TypeError: The message is not of the topic's type.
        """
        topic = self._topics.get(name)
        if topic is None:
            # Nobody wants it any more.
            return
        if not isinstance(message, topic.msg_type):
            raise topic.refusal(name, message)
        for subscription in topic.subscriptions:
            if subscription.link is not link:
                subscription.deliver(message)

    def _tell_links(self, name: str, topic: _Topic) -> None:
        for link in self._links:
            link.audience_changed(name, topic.msg_type, topic.depth_for(link))

    def _enter(self, name: str, msg_type: type) -> _Topic:
        topic = self._topics.setdefault(name, _Topic(msg_type))
        if topic.msg_type is not msg_type:
            raise BackendError(
                f"{name} carries {topic.msg_type.__name__}, so it cannot carry {msg_type.__name__}"
            )
        topic.users += 1
        return topic

    def _leave(self, name: str) -> None:
        topic = self._topics[name]
        topic.users -= 1
        if not topic.users:
            del self._topics[name]


_process_bus = Bus()


def process_bus() -> Bus:
    """The bus of this process, on which every backend is that is not given one of its own."""
    return _process_bus
