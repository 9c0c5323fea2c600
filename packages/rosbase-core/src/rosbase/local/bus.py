"""Topics and services within one process: every subscription gets the same message object.

A link leads to another process. It subscribes here to the topics wanted there, and learns which
topics are wanted here.
"""

import threading
from collections.abc import Callable, Iterable
from functools import partial
from itertools import count
from typing import Any, TypeAlias

from rosbase.contracts.tap import Tap
from rosbase.errors import BackendError
from rosbase.local.endpoints import (
    BusLink,
    Channel,
    LocalPublisher,
    LocalSubscription,
    make_publisher,
)
from rosbase.local.feed import Feed
from rosbase.local.service_registry import ServiceRegistry
from rosbase.logger import RosbaseLogger
from rosbase.qos import QoSProfile, ReliabilityPolicy, mismatch

__all__ = ["Bus", "MakePublisher", "process_bus"]

MakePublisher: TypeAlias = Callable[[str, type, QoSProfile], LocalPublisher]
"""Makes a publisher of a topic, of a type, with a profile."""


class _Topic:
    """A topic: its name and type, its publishers and its subscriptions."""

    __slots__ = ("msg_type", "publishers", "subscriptions")

    def __init__(self, msg_type: type) -> None:
        self.msg_type = msg_type
        self.publishers: list[LocalPublisher] = []
        # Replaced, so that a link delivers without the lock.
        self.subscriptions: tuple[LocalSubscription, ...] = ()

    def wanted_on(self, channel: Channel, link: BusLink) -> QoSProfile | None:
        """Return the profile of the greatest depth among subscriptions other than this link's."""
        return max(
            (s.profile for s in self.subscriptions if s.channel == channel and s.link is not link),
            key=lambda profile: profile.queue_depth,
            default=None,
        )

    def widest_from(self, link: BusLink) -> Channel | None:
        """Return the channel on which a link brings most: what comes on others comes on it too.

        Not quite: a latched publisher of lower reliability than a volatile subscription reaches
        latched subscriptions only.
        """
        found = min(
            (s for s in self.subscriptions if s.link is not link), key=_narrowness, default=None
        )
        return found.channel if found else None


def _narrowness(subscription: LocalSubscription) -> tuple[bool, bool, int]:
    number = subscription.channel if isinstance(subscription.channel, int) else 0
    is_reliable = subscription.profile.reliability is ReliabilityPolicy.RELIABLE
    return subscription.profile.is_latched, is_reliable, number


class Bus:
    """All topics and services of a process, or of a test."""

    def __init__(self) -> None:
        self.services = ServiceRegistry()
        """Its services."""
        self._topics: dict[str, _Topic] = {}
        self._taps: dict[str, tuple[Tap, ...]] = {}
        self._links: tuple[BusLink, ...] = ()
        self._feeds: dict[str, Feed] = {}
        self._latched_numbers = count(1)
        self._logger = RosbaseLogger("topics")
        self._lock = threading.Lock()

    def add_publisher(
        self,
        name: str,
        msg_type: type,
        profile: QoSProfile,
        make: MakePublisher = make_publisher,
    ) -> LocalPublisher:
        """Add a publisher of the topic with that full name, which `make` makes.

        Raises:
            BackendError: The topic has another type.
        """
        with self._lock:
            topic = self._enter(name, msg_type)
            publisher = make(name, msg_type, profile)
            topic.publishers.append(publisher)
            is_fed = name in self._feeds
            if name in self._taps and not is_fed:
                publisher.set_taps(self._takers(name))
            heard = () if is_fed else topic.subscriptions
            reasons = [_connect(publisher, other) for other in heard]
        self._warn(name, reasons)
        return publisher

    def add_subscription(self, subscription: LocalSubscription, msg_type: type) -> None:
        """Add a subscription: it receives kept messages, and new ones from now on.

        Raises:
            BackendError: The topic has another type.
        """
        with self._lock:
            topic = self._enter(subscription.topic, msg_type)
            if subscription.profile.is_latched:
                subscription.channel = next(self._latched_numbers)
            topic.subscriptions = (*topic.subscriptions, subscription)
            feed = self._feeds.get(subscription.topic)
            if feed is not None:
                feed.welcome(subscription)
            publishers = topic.publishers if feed is None else ()
            reasons = [_connect(publisher, subscription) for publisher in publishers]
            self._tell_links(subscription, topic)
        self._warn(subscription.topic, reasons)

    def remove_publisher(self, publisher: LocalPublisher) -> None:
        """Remove a publisher from `add_publisher`, with its kept messages."""
        with self._lock:
            publisher.close()
            self._topics[publisher.topic].publishers.remove(publisher)
            self._leave(publisher.topic)

    def take_over(self, name: str, depth: int) -> Callable[[Any], None]:
        """Have the publishers of a topic reach nobody from now on.

        Returns the function that delivers in their place; it raises TypeError if a message is not
        of the topic's type.

        Args:
            name: Full name of the topic.
            depth: Number of messages that are kept for subscriptions that come later.
        """
        with self._lock:
            self._feeds.setdefault(name, Feed(depth))
            topic = self._topics.get(name)
            for publisher in topic.publishers if topic else ():
                publisher.close()
        return partial(self._feed, name)

    def give_back(self, name: str) -> None:
        """Undo `take_over` for publishers that come later. Do nothing if it is undone."""
        with self._lock:
            self._feeds.pop(name, None)

    def add_tap(self, tap: Tap) -> None:
        """Have a tap hear what is published here, and what comes from links, from now on."""
        with self._lock:
            self._taps[tap.topic] = (*self._taps.get(tap.topic, ()), tap)
            self._connect_taps(tap.topic)

    def remove_tap(self, tap: Tap) -> None:
        """Remove a tap from `add_tap`. Do nothing if it has been removed."""
        with self._lock:
            left = tuple(other for other in self._taps.pop(tap.topic, ()) if other is not tap)
            if left:
                self._taps[tap.topic] = left
            self._connect_taps(tap.topic)

    def is_tapped(self, name: str) -> bool:
        """Return whether a tap hears a topic."""
        return name in self._taps

    def kept_messages(self, name: str) -> list[Any]:
        """Return what the publishers of a topic keep for subscriptions that come later."""
        with self._lock:
            if name in self._feeds:
                return self._feeds[name].kept_messages()
            topic = self._topics.get(name)
            publishers = topic.publishers if topic else ()
            return [message for publisher in publishers for message in publisher.kept_messages()]

    def type_of(self, name: str) -> type | None:
        """Return the type of a topic; None if nobody uses it."""
        topic = self._topics.get(name)
        return topic.msg_type if topic else None

    def heard_type(self, name: str) -> type | None:
        """Return the type of a topic that has subscriptions; None if it has none."""
        topic = self._topics.get(name)
        return topic.msg_type if topic is not None and topic.subscriptions else None

    def resize_subscription(self, subscription: LocalSubscription, profile: QoSProfile) -> None:
        """Let the subscription keep as many messages as the profile says."""
        with self._lock:
            subscription.profile = profile
            subscription.resize(profile.queue_depth)
            self._tell_links(subscription, self._topics[subscription.topic])

    def remove_subscription(self, subscription: LocalSubscription) -> None:
        """Remove a subscription from `add_subscription`."""
        subscription.close()
        with self._lock:
            topic = self._topics[subscription.topic]
            topic.subscriptions = tuple(s for s in topic.subscriptions if s is not subscription)
            for publisher in topic.publishers:
                publisher.disconnect(subscription)
            self._tell_links(subscription, topic)
            self._leave(subscription.topic)

    def add_link(self, link: BusLink) -> None:
        """Tell the link which topics are wanted here, now and from now on."""
        with self._lock:
            self._links = (*self._links, link)
            for topic in self._topics.values():
                for subscription in topic.subscriptions:
                    _tell(link, subscription, topic)

    def remove_link(self, link: BusLink) -> None:
        """Stop telling the link. It must remove its own subscriptions."""
        with self._lock:
            self._links = tuple(other for other in self._links if other is not link)

    def deliver_from(self, link: BusLink, name: str, channel: Channel, message: Any) -> None:
        """Queue a message from the link for the subscriptions that the channel serves.

        Raises:
            TypeError: The message is not of the topic's type.
        """
        topic = self._topics.get(name)
        if topic is None:
            # Nobody wants it any more.
            return
        if not isinstance(message, topic.msg_type):
            raise TypeError(f"{name} takes {topic.msg_type.__name__}, not {type(message).__name__}")
        for subscription in topic.subscriptions:
            if subscription.channel == channel and subscription.link is not link:
                subscription.deliver(message)

    def _deliver_with_taps(self, link: BusLink, name: str, channel: Channel, message: Any) -> None:
        """Take the place of `deliver_from` while there is a tap."""
        Bus.deliver_from(self, link, name, channel, message)
        topic, taps = self._topics.get(name), self._taps.get(name, ())
        # It comes once for each channel.
        if taps and topic is not None and topic.widest_from(link) == channel:
            for tap in taps:
                tap.take(message)

    def _connect_taps(self, name: str) -> None:
        topic, takers = self._topics.get(name), self._takers(name)
        # A feed finds them by itself.
        for publisher in topic.publishers if topic and name not in self._feeds else ():
            publisher.set_taps(takers)
        # So what comes from links has no cost without a tap.
        if self._taps:
            vars(self)["deliver_from"] = self._deliver_with_taps
        else:
            vars(self).pop("deliver_from", None)

    def _feed(self, name: str, message: Any) -> None:
        topic, feed = self._topics.get(name), self._feeds.get(name)
        if feed is None:
            return
        if topic is not None and not isinstance(message, topic.msg_type):
            raise TypeError(f"{name} takes {topic.msg_type.__name__}, not {type(message).__name__}")
        subscriptions = topic.subscriptions if topic is not None else ()
        feed.deliver(message, subscriptions, self._takers(name))

    def _takers(self, name: str) -> tuple[Callable[[Any], None], ...]:
        return tuple(tap.take for tap in self._taps.get(name, ()))

    def _tell_links(self, subscription: LocalSubscription, topic: _Topic) -> None:
        for link in self._links:
            _tell(link, subscription, topic)

    def _warn(self, name: str, reasons: Iterable[str]) -> None:
        """Warn once per topic of subscriptions that get nothing.

        Call it without the lock, because a log may be a topic.
        """
        for reason in filter(None, reasons):
            self._logger.log_once(
                f"{name}: a subscription gets nothing from a publisher: {reason}", "WARNING"
            )

    def _enter(self, name: str, msg_type: type) -> _Topic:
        topic = self._topics.setdefault(name, _Topic(msg_type))
        if topic.msg_type is not msg_type:
            raise BackendError(
                f"{name} carries {topic.msg_type.__name__}, so it cannot carry {msg_type.__name__}"
            )
        return topic

    def _leave(self, name: str) -> None:
        topic = self._topics[name]
        if not topic.publishers and not topic.subscriptions:
            del self._topics[name]


def _connect(publisher: LocalPublisher, subscription: LocalSubscription) -> str:
    """Connect the two, or return the reason why they do not match."""
    reason = mismatch(publisher.profile, subscription.profile)
    if not reason:
        publisher.connect(subscription)
    return reason


def _tell(link: BusLink, subscription: LocalSubscription, topic: _Topic) -> None:
    profile = topic.wanted_on(subscription.channel, link)
    link.audience_changed(subscription.topic, topic.msg_type, subscription.channel, profile)


_process_bus = Bus()


def process_bus() -> Bus:
    """Return the bus of this process, for every backend without its own."""
    return _process_bus
