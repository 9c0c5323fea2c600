"""Topics within one process: a message is handed over as it is, to every subscription."""

import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from rosbase.errors import BackendError

__all__ = ["Bus", "LocalPublisher", "LocalSubscription"]


class LocalSubscription:
    """The last messages of a topic, waiting for the callback."""

    __slots__ = ("_callback", "_closed", "_dropped", "_lock", "_queue", "_schedule", "topic")

    def __init__(
        self,
        topic: str,
        callback: Callable[[Any], object],
        depth: int,
        schedule: Callable[[Callable[[], object]], None],
    ) -> None:
        self.topic = topic
        self._callback = callback
        self._queue: deque[Any] = deque(maxlen=depth)
        self._schedule = schedule
        # Guards the queue together with the count; held for a few instructions.
        self._lock = threading.Lock()
        self._dropped = 0
        self._closed = False

    @property
    def dropped(self) -> int:
        """How many messages were lost because the callback was slower than the publisher."""
        return self._dropped

    def deliver(self, message: Any) -> None:
        """Queues a message, from any thread; the oldest goes if the queue is full."""
        queue = self._queue
        with self._lock:
            if self._closed:
                return
            waiting = len(queue)
            if waiting == queue.maxlen:
                self._dropped += 1
            queue.append(message)
        # One call is under way for each message in the queue, so a full queue needs no more.
        if waiting != queue.maxlen:
            self._schedule(self.handle_one)

    def handle_one(self) -> None:
        """Calls back with the oldest message. On the spinning thread."""
        with self._lock:
            if self._closed or not self._queue:
                return
            message = self._queue.popleft()
        self._callback(message)

    def close(self) -> None:
        """No callback from here on."""
        with self._lock:
            self._closed = True
            self._queue.clear()


class _Topic:
    """A name, its type, and who listens. Replaced lists, so that publishing needs no lock."""

    __slots__ = ("deliveries", "msg_type", "users")

    def __init__(self, msg_type: type) -> None:
        self.msg_type = msg_type
        self.deliveries: tuple[Callable[[Any], None], ...] = ()
        self.users = 0


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
            raise TypeError(
                f"{self.topic} takes {topic.msg_type.__name__}, not {type(message).__name__}"
            )
        for deliver in topic.deliveries:
            deliver(message)

    def close(self) -> None:
        """Nothing can be published from here on."""
        self._topic = None


class Bus:
    """All topics of a process, or of a test."""

    def __init__(self) -> None:
        self._topics: dict[str, _Topic] = {}
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
            topic.deliveries = (*topic.deliveries, subscription.deliver)

    def remove_publisher(self, publisher: LocalPublisher) -> None:
        """Ends a publisher that `add_publisher` gave."""
        publisher.close()
        with self._lock:
            self._leave(publisher.topic)

    def remove_subscription(self, subscription: LocalSubscription) -> None:
        """Ends a subscription that `add_subscription` took."""
        subscription.close()
        with self._lock:
            topic = self._topics[subscription.topic]
            topic.deliveries = tuple(d for d in topic.deliveries if d != subscription.deliver)
            self._leave(subscription.topic)

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
