"""Taps of a backend: they hear what its rclpy nodes publish, and what comes from other processes.

A publisher without a tap is untouched: while there is one, `publish` of the rclpy publisher is
another function. What a subscription receives says nothing of who has sent it, so messages of this
process are recognised by their bytes.
"""

import threading
from collections import Counter, deque
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rclpy.exceptions import InvalidHandle
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.serialization import serialize_message

from rosbase import Tap
from rosbase_ros2.formats import rewriter
from rosbase_ros2.shared_node import SharedNode
from rosbase_ros2.topics import RosPublisher, RosSubscription

__all__ = ["Taps"]

# Own messages that have been sent, and not yet received.
_MOST_OWN = 1000
_BEGIN, _END = 256, 64


class Taps:
    """The taps of all nodes of a backend. Any thread may use it."""

    def __init__(
        self, nodes: Sequence[SharedNode], on_fault: Callable[[Tap, Exception], object]
    ) -> None:
        """Start without a tap.

        Args:
            nodes: The rclpy nodes; there may be more of them later.
            on_fault: Called when the function of a tap has raised; see `Tap`.
        """
        self._nodes = nodes
        self._on_fault = on_fault
        self._taps: dict[str, tuple[Tap, ...]] = {}
        self._ears: dict[str, _Ear] = {}
        self.publishers: list[RosPublisher] = []
        """Publishers of rosbase on these nodes."""
        self.subscriptions: list[RosSubscription] = []
        """Subscriptions of rosbase on these nodes."""
        self._lock = threading.RLock()

    def open(self, name: str, on_message: Callable[[Any], object]) -> Tap:
        """Open a tap of the topic with that full name."""
        tap = Tap(name, on_message, self._close, self._on_fault)
        with self._lock:
            self._taps[name] = (*self._taps.get(name, ()), tap)
            self._connect(name)
        return tap

    def close(self) -> None:
        """Close all taps."""
        for tap in [tap for taps in [*self._taps.values()] for tap in taps]:
            tap.close()

    def kept_messages(self, name: str) -> list[bytes]:
        """Return what the publishers of rosbase on a topic keep."""
        with self._lock:
            publishers = [one for one in self.publishers if one.topic == name]
        return [data for publisher in publishers for data in publisher.kept_messages()]

    def welcome(self, inner: Any) -> None:
        """Note that a node has a new publisher of rclpy."""
        if self._taps:
            with self._lock:
                self._set(inner, _name_of(inner))

    def add_publisher(self, publisher: RosPublisher) -> None:
        """Note a new publisher of rosbase."""
        with self._lock:
            self.publishers.append(publisher)
            publisher.refresh()

    def remove_publisher(self, publisher: RosPublisher) -> None:
        """Note that a publisher of rosbase is about to end."""
        with self._lock:
            self.publishers.remove(publisher)

    def add_subscription(self, subscription: RosSubscription) -> None:
        """Note a new subscription of rosbase."""
        with self._lock:
            self.subscriptions.append(subscription)
            if subscription.topic in self._taps:
                self._connect(subscription.topic)

    def remove_subscription(self, subscription: RosSubscription) -> None:
        """Note that a subscription of rosbase is about to end."""
        with self._lock:
            self.subscriptions.remove(subscription)
            if subscription.topic in self._taps:
                self._connect(subscription.topic)

    def _close(self, tap: Tap) -> None:
        with self._lock:
            left = tuple(other for other in self._taps.pop(tap.topic, ()) if other is not tap)
            if left:
                self._taps[tap.topic] = left
            self._connect(tap.topic)

    def _connect(self, name: str) -> None:
        """Have everything on a topic hand its messages to the taps there are now."""
        self._set_ear(name)
        for inner in self._inners(name):
            self._set(inner, name)
        for publisher in self.publishers:
            if publisher.topic == name:
                publisher.refresh()

    def _inners(self, name: str) -> list[Any]:
        inners = [inner for node in self._nodes for inner in [*node.publishers]]
        return [inner for inner in inners if _name_of(inner) == name]

    def _set(self, inner: Any, name: str) -> None:
        """Replace `publish` of an rclpy publisher, or give it back."""
        vars(inner).pop("publish", None)
        takers = self._takers(name)
        if takers:
            ear = self._ears.get(name)
            inner.publish = _tapped(inner.publish, takers, ear.own if ear else None)

    def _set_ear(self, name: str) -> None:
        """Choose the subscription by which messages of other processes are heard."""
        known = self._ears.pop(name, None)
        if known is not None:
            known.close()
        takers = self._takers(name)
        found = [one for one in self.subscriptions if one.topic == name] if takers else []
        if found:
            chosen = min(found, key=_narrowness)
            own = known.own if known is not None else _OwnMessages(chosen.inner.msg_type)
            self._ears[name] = _Ear(chosen, takers, own)

    def _takers(self, name: str) -> list[Callable[[Any], None]]:
        return [tap.take for tap in self._taps.get(name, ())]


class _Ear:
    """A subscription whose messages go to taps too, if they are of other processes."""

    def __init__(
        self,
        subscription: RosSubscription,
        takers: Sequence[Callable[[Any], None]],
        own: "_OwnMessages",
    ) -> None:
        self.own = own
        self._subscription = subscription
        deliver = subscription.deliver

        def hear(received: Any) -> None:
            deliver(received)
            if not own.has_sent(received):
                for take in takers:
                    take(received)

        subscription.inner.callback = hear

    def close(self) -> None:
        """Give the subscription back."""
        self._subscription.inner.callback = self._subscription.deliver


class _OwnMessages:
    """Messages that this process has sent, and may receive itself. Any thread may use it.

    What rosbase writes arrives as it is. What rclpy writes has any bytes in its gaps, so it is
    written anew by rosbase for the comparison.
    """

    def __init__(self, ros_type: Any) -> None:
        self._ros_type = ros_type
        self._rewrite: Callable[[bytes], bytes] | None = None
        self._has_objects = False
        self._order: deque[_Mark] = deque()
        self._counts: Counter[_Mark] = Counter()
        self._lock = threading.Lock()

    def note(self, message: Any) -> None:
        """Note a message before it is sent."""
        if isinstance(message, bytes):
            mark = _mark(message)
        else:
            mark, self._has_objects = self._written_mark(message), True
        with self._lock:
            self._order.append(mark)
            self._counts[mark] += 1
            if len(self._order) > _MOST_OWN:
                # Lost on the way, or received long ago.
                self._forget(self._order.popleft())

    def has_sent(self, message: Any) -> bool:
        """Return whether a received message is one of these; each counts once."""
        if isinstance(message, bytes) and self._take(_mark(message)):
            return True
        is_object = not isinstance(message, bytes)
        return (is_object or self._has_objects) and self._take(self._written_mark(message))

    def _take(self, mark: "_Mark") -> bool:
        with self._lock:
            if mark not in self._counts:
                return False
            self._order.remove(mark)
            self._forget(mark)
            return True

    def _forget(self, mark: "_Mark") -> None:
        self._counts[mark] -= 1
        if not self._counts[mark]:
            del self._counts[mark]

    def _written_mark(self, message: Any) -> "_Mark":
        data = message if isinstance(message, bytes) else bytes(serialize_message(message))
        if self._rewrite is None:
            self._rewrite = rewriter(self._ros_type)
        return _mark(self._rewrite(data))


def _tapped(
    publish: Callable[[Any], object],
    takers: Sequence[Callable[[Any], None]],
    own: _OwnMessages | None,
) -> Callable[[Any], object]:
    """Return a function that publishes a message, and hands it to taps."""

    def publish_and_tap(message: Any) -> None:
        if own is not None:
            own.note(message)
        publish(message)
        for take in takers:
            take(message)

    return publish_and_tap


_Mark: TypeAlias = tuple[int, bytes, bytes]


def _mark(data: bytes) -> _Mark:
    return len(data), data[:_BEGIN], data[-_END:]


def _name_of(inner: Any) -> str:
    try:
        name: str = inner.topic_name
    except InvalidHandle:
        # Another thread has just destroyed it.
        return ""
    return name


def _narrowness(subscription: RosSubscription) -> tuple[bool, bool]:
    """Return the order in which subscriptions are asked: one of best effort hears the most."""
    profile = subscription.inner.qos_profile
    return (
        profile.durability is DurabilityPolicy.TRANSIENT_LOCAL,
        profile.reliability is not ReliabilityPolicy.BEST_EFFORT,
    )
