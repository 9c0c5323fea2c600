"""The two ends of a topic: a publisher hands messages to the matching subscriptions."""

import copy
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, Protocol, TypeAlias

from rosbase.messages.fields import is_frozen
from rosbase.qos import QoSProfile
from rosbase.runtime.queued_subscription import QueuedSubscription

__all__ = [
    "BusLink",
    "Channel",
    "LatchedPublisher",
    "LocalPublisher",
    "LocalSubscription",
    "make_publisher",
    "publisher_class",
]

Channel = str | int
"""Group of a topic's subscriptions that a link serves together.

All volatile ones of the same reliability form a group, by its name. Each latched one has its own,
by a number.
"""


class BusLink(Protocol):
    """Interface through which a bus informs a link."""

    def audience_changed(
        self, topic: str, msg_type: type, channel: Channel, profile: QoSProfile | None
    ) -> None:
        """Note that subscriptions other than the link's own to a topic have changed.

        Args:
            topic: Its full name.
            msg_type: The type of its messages.
            channel: The group of subscriptions.
            profile: Their profile of the greatest depth; None if there is none left.
        """
        ...


class LocalSubscription(QueuedSubscription):
    """Messages of a topic of this process, kept as its profile asks."""

    __slots__ = ("channel", "link", "profile")

    def __init__(
        self,
        topic: str,
        callback: Callable[[Any], object],
        profile: QoSProfile,
        schedule: Callable[[Callable[[], object]], None],
        link: BusLink | None = None,
    ) -> None:
        super().__init__(topic, callback, profile.queue_depth, schedule)
        self.profile = profile
        self.link = link
        """Link that subscribes on behalf of another process, if it is one."""
        self.channel: Channel = profile.reliability.name
        """Channel by which links know it. The bus gives a latched one its number."""


_Takers: TypeAlias = tuple[Callable[[Any], None], ...]


class LocalPublisher:
    """Hands messages to the subscriptions of one topic."""

    __slots__ = ("_deliveries", "_matching", "_msg_type", "_taps", "profile", "topic")

    def __init__(self, topic: str, msg_type: type, profile: QoSProfile) -> None:
        self.topic = topic
        self.profile = profile
        self._msg_type = msg_type
        # Replaced, never changed, so that publishing needs no lock.
        self._matching: _Takers = ()
        self._taps: _Takers = ()
        # Both; without a tap, the very tuple of the subscriptions.
        self._deliveries: _Takers = ()

    def publish(self, message: Any) -> None:
        """Queue the message for every matching subscription. Call it from any thread.

        Raises:
            TypeError: The message is not of the topic's type.
        """
        if not isinstance(message, self._msg_type):
            raise TypeError(
                f"{self.topic} takes {self._msg_type.__name__}, not {type(message).__name__}"
            )
        for deliver in self._deliveries:
            deliver(message)

    @property
    def subscription_count(self) -> int:
        """Number of subscriptions that hear it."""
        return len(self._matching)

    # Called by the bus, one at a time.

    def connect(self, subscription: LocalSubscription) -> None:
        """Connect the subscription: it receives messages published from now on."""
        self._matching = (*self._matching, subscription.deliver)
        self._join()

    def disconnect(self, subscription: LocalSubscription) -> None:
        """Disconnect the subscription. Do nothing if it is not connected."""
        self._matching = tuple(d for d in self._matching if d != subscription.deliver)
        self._join()

    def set_taps(self, taps: _Takers) -> None:
        """Hand each message to these, too, from now on."""
        self._taps = taps
        self._join()

    def kept_messages(self) -> list[Any]:
        """Return what is kept for subscriptions that come later, the oldest first."""
        return []

    def close(self) -> None:
        """Close the publisher: nobody receives its messages from now on."""
        self._matching, self._taps = (), ()
        self._join()

    def _join(self) -> None:
        self._deliveries = (*self._matching, *self._taps) if self._taps else self._matching


class LatchedPublisher(LocalPublisher):
    """Keeps its last messages for the subscriptions that come later."""

    __slots__ = ("_kept", "_lock")

    def __init__(self, topic: str, msg_type: type, profile: QoSProfile) -> None:
        super().__init__(topic, msg_type, profile)
        self._kept: deque[Any] = deque(maxlen=profile.queue_depth)
        # Nothing may be published between what was kept and the first that comes by itself.
        self._lock = threading.Lock()

    def publish(self, message: Any) -> None:
        """Queue the message as any publisher does, and keep it."""
        with self._lock:
            super().publish(message)
            self._kept.append(message)

    def connect(self, subscription: LocalSubscription) -> None:
        """Connect the subscription; first deliver kept messages if it asks and has room."""
        with self._lock:
            if subscription.profile.is_latched:
                for message in list(self._kept)[-subscription.depth :]:
                    subscription.deliver(message)
            super().connect(subscription)

    def set_taps(self, taps: _Takers) -> None:
        """Hand each message to these, too; one that is being published goes to those before."""
        with self._lock:
            super().set_taps(taps)

    def kept_messages(self) -> list[Any]:
        """Return what is kept for subscriptions that come later, the oldest first."""
        with self._lock:
            return list(self._kept)

    def close(self) -> None:
        """Close the publisher and drop its kept messages."""
        with self._lock:
            super().close()
            self._kept = deque(maxlen=0)


class CopyingPublisher(LocalPublisher):
    """Hands on copies of messages that can be changed.

    Programs for rclpy fill one object again and again. Without a copy, a subscriber would find the
    last content in every message that waits for it.
    """

    __slots__ = ()

    def publish(self, message: Any) -> None:
        """Queue a copy of the message for every matching subscription."""
        super().publish(copy.deepcopy(message))


class CopyingLatchedPublisher(LatchedPublisher):
    """Keeps and hands on copies of messages that can be changed."""

    __slots__ = ()

    def publish(self, message: Any) -> None:
        """Queue a copy of the message, and keep it."""
        super().publish(copy.deepcopy(message))


def publisher_class(msg_type: type, profile: QoSProfile) -> type[LocalPublisher]:
    """Return the class of publishers that keep messages as the profile says."""
    if is_frozen(msg_type):
        return LatchedPublisher if profile.is_latched else LocalPublisher
    return CopyingLatchedPublisher if profile.is_latched else CopyingPublisher


def make_publisher(topic: str, msg_type: type, profile: QoSProfile) -> LocalPublisher:
    """Create a publisher that keeps messages as its profile says."""
    return publisher_class(msg_type, profile)(topic, msg_type, profile)
