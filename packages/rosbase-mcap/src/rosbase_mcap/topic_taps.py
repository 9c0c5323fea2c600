"""Hear the topics of a program, from within."""

import threading
from collections.abc import Callable, Iterable
from typing import Any

from rosbase import Backend, BackendError, Graph, MessageFormat, RosbaseLogger, Tap, TopicEnd
from rosbase_mcap.channel_table import LATCHED, QOS, Channels
from rosbase_mcap.errors import McapError
from rosbase_mcap.log_channel import LOG_TOPIC, no_output
from rosbase_mcap.qos_text import profiles_text

__all__ = ["TopicTaps", "wanted"]

# It has a publisher once somebody listens, so no graph shows it before.
_PARAMETER_EVENTS = TopicEnd("", "/parameter_events", "rcl_interfaces/msg/ParameterEvent")


class TopicTaps:
    """Records the topics that a backend publishes or receives, new ones from their first message.

    Any thread may use it.
    """

    def __init__(
        self,
        backend: Backend,
        channels: Channels,
        logger: RosbaseLogger,
        is_wanted: Callable[[str], bool] = lambda topic: True,
    ) -> None:
        """Prepare; `begin` begins to hear.

        Args:
            backend: Connection of the program.
            channels: Takes the messages.
            logger: Says which topics cannot be recorded.
            is_wanted: Whether to record a topic of that full name.
        """
        self._backend, self._channels, self._logger = backend, channels, logger
        self._is_wanted = is_wanted
        # What a recorded program reads of its clock is recorded too: not what is read for it.
        self._now_ns = getattr(backend.clock, "machine", backend.clock).now_ns
        self._taps: dict[str, Tap | None] = {}
        self._is_closed = False
        # A listener may log, and the log may be a new topic.
        self._lock = threading.RLock()

    def begin(self) -> None:
        """Hear the topics that there are, and each new one."""
        self._backend.new_ends.add(self._welcome)
        try:
            ends = _by_topic(self._backend.graph())
        except BackendError:
            # It has no graph.
            return
        for topic, found in ends.items():
            self._add(topic, found)

    def close(self) -> None:
        """Hear nothing any more."""
        self._backend.new_ends.remove(self._welcome)
        with self._lock:
            self._is_closed = True
            taps = [tap for tap in self._taps.values() if tap is not None]
        for tap in taps:
            tap.close()

    def _welcome(self, end: TopicEnd) -> None:
        self._add(end.name, [end])

    def _add(self, topic: str, ends: list[TopicEnd]) -> None:
        with self._lock:
            if topic in self._taps or self._is_closed or not self._is_wanted(topic):
                return
            # The log may have a topic of its own, whose first message comes meanwhile.
            self._taps[topic] = None
            self._taps[topic] = self._heard(topic, ends)

    def _heard(self, topic: str, ends: list[TopicEnd]) -> Tap | None:
        try:
            return self._hear(topic, ends)
        except (BackendError, McapError, TypeError) as error:
            self._complain(f"{topic} is not recorded: {error}")
            return None

    def _hear(self, topic: str, ends: list[TopicEnd]) -> Tap:
        form = self._format(ends[0])
        metadata = _metadata(form, ends)
        record = self._channels.channel(topic, form.type_name, form.schema, metadata)
        hear = _hearing(form.encode, record, self._now_ns, self._refuse(topic))
        early: list[int] = []

        def first(message: Any) -> None:
            # What comes before the kept ones are known may be among them.
            early.append(id(message))
            hear(message)

        tap = self._backend.add_tap(topic, first)
        for message in self._backend.kept_messages(topic):
            if id(message) not in early:
                hear(message)
        tap.hand_to(hear)
        return tap

    def _format(self, end: TopicEnd) -> MessageFormat:
        msg_type = end.msg_type or self._backend.find_type(end.type_name)
        return self._backend.message_format(msg_type)

    def _refuse(self, topic: str) -> Callable[[Exception], object]:
        is_said = False

        def refuse(error: Exception) -> None:
            nonlocal is_said
            if not is_said:
                is_said = True
                self._complain(f"a message of {topic} is not recorded: {error}")

        return refuse

    def _complain(self, line: str) -> None:
        with no_output():
            self._logger.warning(line)


def wanted(topics: Iterable[str], *, log: bool = False) -> Callable[[str], bool]:
    """Return the function that says whether a topic is recorded.

    Args:
        topics: Those that the user has chosen; none stands for all.
        log: Whether the log is meant: its lines come from the loggers, not from a topic.
    """
    names = {f"/{topic.lstrip('/')}" for topic in topics}
    return lambda topic: (not names or topic in names) and (log or topic != LOG_TOPIC)


def _hearing(
    encode: Callable[[Any], bytes],
    record: Callable[[int, int, bytes], object],
    now_ns: Callable[[], int],
    refuse: Callable[[Exception], object],
) -> Callable[[Any], None]:
    """Return the function that records a message on the thread that publishes it.

    It is written as bytes at once, because it may change later, and its length counts.
    """

    def hear(message: Any) -> None:
        stamp_ns = now_ns()
        if type(message) is bytes:
            record(stamp_ns, stamp_ns, message)
            return
        try:
            data = encode(message)
        except (TypeError, ValueError) as error:
            refuse(error)
            return
        record(stamp_ns, stamp_ns, data)

    return hear


def _by_topic(graph: Graph) -> dict[str, list[TopicEnd]]:
    """Return the ends of each topic, publishers first."""
    found: dict[str, list[TopicEnd]] = {}
    for end in (*graph.publishers, *graph.subscriptions, _PARAMETER_EVENTS):
        found.setdefault(end.name, []).append(end)
    return found


def _metadata(form: MessageFormat, ends: list[TopicEnd]) -> dict[str, str]:
    profiles = [end.profile for end in ends if end.profile is not None]
    metadata = {QOS: profiles_text(profiles)}
    if form.type_hash:
        metadata["topic_type_hash"] = form.type_hash
    if any(profile.is_latched for profile in profiles):
        metadata[LATCHED] = "true"
    return metadata
