"""Topics as channels of the server."""

import threading
from collections import Counter
from collections.abc import Callable, Hashable

from attrs import define, field
from foxglove import Channel

from rosbase import ControlError
from rosbase.control.names import is_hidden
from rosbase.control.shapes import Topic
from rosbase.messages.tf2_msgs import TFMessage
from rosbase.wire import schema
from rosbase_view.foxglove.names import NameTable, candidates
from rosbase_view.foxglove.notices import Notices
from rosbase_view.foxglove.server import Server
from rosbase_view.foxglove.transforms import TF, TF_TYPE, Transforms
from rosbase_view.foxglove.wanted import Listened
from rosbase_view.imu_picture import IMU
from rosbase_view.reports import Survey, TopicKey

__all__ = ["Channels", "programs_of"]

_OWN_TRANSFORMS = (TF, "/tf_static")


@define
class _Open:
    """A channel, and where its messages come from."""

    channel: Channel
    type: str
    schema: str
    topic: TopicKey | None
    """None for the transforms that are made here, and while the program is gone."""
    dropped: dict[Hashable, int] = field(factory=dict)
    """Messages that each stream has lost."""
    was_dropped: int = 0
    """Messages that had been lost at the last look."""


class Channels:
    """Keeps a channel for each topic. One thread updates it; others may bring messages."""

    def __init__(
        self,
        server: Server,
        notices: Notices,
        schema_of: Callable[[TopicKey, Topic], tuple[str, str]],
    ) -> None:
        """Begin without channels.

        Args:
            server: Where they are offered.
            notices: Takes what the user should know.
            schema_of: Returns the type of a topic and its schema. It raises ControlError if it
                does not know them, of the kind `failed` if there are none.
        """
        self._server, self._notices, self._schema_of = server, notices, schema_of
        self._names: NameTable[TopicKey] = NameTable()
        self._imus: frozenset[TopicKey] = frozenset()
        self._transforms = Transforms()
        self._makes_transforms = False
        # The SDK calls back while a channel closes, so nothing of it is called with this lock.
        self._lock = threading.Lock()
        self._open: dict[str, _Open] = {}
        # By name, how many clients have begun to listen so far. A client may do so before `_open`
        # has its channel.
        self._listeners: Counter[str] = Counter()
        self._by_topic: dict[TopicKey, _Open] = {}
        self._faulty: set[TopicKey] = set()

    def update(self, survey: Survey) -> dict[str, Topic]:
        """Offer the topics that there are; return them by the names that clients see."""
        names = self._names.update(_candidates(survey))
        for name, key in names.items():
            self._offer(name, key, survey.topics[key])
        self._offer_transforms(survey)
        for name in set(self._open) - set(names):
            if name != TF or not self._makes_transforms:
                self._leave(name)
        with self._lock:
            self._by_topic = {
                one.topic: one for one in self._open.values() if one.topic is not None
            }
        self._faulty &= set(survey.topics)
        self._transforms.keep(survey.topics)
        self._say_dropped()
        return {name: survey.topics[key] for name, key in names.items()}

    def key_of(self, name: str) -> TopicKey | None:
        """Return the topic of a channel. Any thread may ask."""
        with self._lock:
            found = self._open.get(name)
            return None if found is None else found.topic

    def count_listener(self, name: str) -> None:
        """Take that a client has begun to listen. Any thread may tell."""
        with self._lock:
            self._listeners[name] += 1

    def listened(self) -> Listened:
        """Return what clients listen to."""
        topics = {
            one.topic: self._listeners[name]
            for name, one in self._open.items()
            # The SDK connects a client a moment before it tells so.
            if one.topic is not None and self._listeners[name] and one.channel.has_sinks()
        }
        is_turned = self._makes_transforms and self._open[TF].channel.has_sinks()
        return Listened(topics, self._imus if is_turned else frozenset())

    def send(self, topic: TopicKey, stamp_ns: int, data: bytes) -> None:
        """Send a message to the clients that listen. Any thread may do so."""
        with self._lock:
            found = self._by_topic.get(topic)
        if found is not None:
            found.channel.log(data, log_time=stamp_ns)

    def send_transform(self, topic: TopicKey, stamp_ns: int, data: bytes) -> None:
        """Send the transform of an Imu. One thread does so."""
        with self._lock:
            found = self._open.get(TF) if self._makes_transforms else None
        if found is not None and (message := self._transforms.of(topic, data)) is not None:
            found.channel.log(message, log_time=stamp_ns)

    def count_dropped(self, topic: TopicKey, stream: Hashable, dropped: int) -> None:
        """Take how many messages a stream of a topic has lost so far."""
        with self._lock:
            if (found := self._by_topic.get(topic)) is not None:
                found.dropped[stream] = dropped

    def _offer(self, name: str, key: TopicKey, topic: Topic) -> None:
        found = self._open.get(name)
        if key in self._faulty or (found is not None and found.topic == key):
            return
        try:
            type_name, text = self._schema_of(key, topic)
        except ControlError as error:
            # Otherwise the program has ended, or is asked again.
            if error.kind == "failed":
                self._faulty.add(key)
                self._notices.say(f"type {name}", f"{name} is not shown: {error}")
            return
        self._set(name, type_name, text, key)

    def _offer_transforms(self, survey: Survey) -> None:
        """Offer transforms made of Imus, if no program has its own."""
        self._imus = frozenset(key for key, topic in survey.topics.items() if IMU in topic["types"])
        # Topics of a recording have no ends at all.
        own = {
            topic["name"]
            for topic in survey.topics.values()
            if topic["publishers"] or not topic["subscriptions"]
        }
        is_used = TF in self._open and self._open[TF].topic is not None
        makes = bool(self._imus) and not is_used and not own.intersection(_OWN_TRANSFORMS)
        if makes:
            self._set(TF, TF_TYPE, schema(TFMessage), None)
        with self._lock:
            self._makes_transforms = makes

    def _set(self, name: str, type_name: str, text: str, key: TopicKey | None) -> None:
        """Give a topic its channel. Clients stay if it is as it was before."""
        found = self._open.get(name)
        if found is not None and (found.type, found.schema) == (type_name, text):
            found.topic = key
            return
        if found is not None:
            self._close(name)
        channel = self._server.open_channel(name, type_name, text)
        with self._lock:
            self._open[name] = _Open(channel, type_name, text, key)

    def _leave(self, name: str) -> None:
        """Close a channel whose topic has gone; one that is listened to waits for its return."""
        found = self._open[name]
        if found.channel.has_sinks():
            found.topic = None
        else:
            self._close(name)

    def _close(self, name: str) -> None:
        with self._lock:
            found = self._open.pop(name)
            self._listeners.pop(name, None)
        found.channel.close()

    def _say_dropped(self) -> None:
        for name, one in self._open.items():
            about, total = f"dropped {name}", sum(one.dropped.values())
            if total > one.was_dropped:
                self._notices.say(about, f"{name} is too fast: some of its messages are dropped")
            else:
                self._notices.end(about)
            one.was_dropped = total


def programs_of(survey: Survey) -> dict[int, str]:
    """Return the name of the program of each process."""
    return {process["pid"]: process["name"] for process in survey.processes}


def _candidates(survey: Survey) -> dict[TopicKey, tuple[str, ...]]:
    programs = programs_of(survey)
    return {
        key: candidates(key[0], programs.get(key[1], ""), key[1])
        for key in survey.topics
        if not is_hidden(key[0])
    }
