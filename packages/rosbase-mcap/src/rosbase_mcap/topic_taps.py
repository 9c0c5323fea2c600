"""Hear the topics of a program, from within."""

import threading
from collections.abc import Callable
from typing import Any

from rosbase import Backend, BackendError, Graph, MessageFormat, RosbaseLogger, Tap, TopicEnd
from rosbase_mcap.channel_table import LATCHED, QOS
from rosbase_mcap.errors import McapError
from rosbase_mcap.qos_text import profiles_text
from rosbase_mcap.recorder import Recorder

__all__ = ["TopicTaps"]

# It has a publisher once somebody listens, so no graph shows it before.
_PARAMETER_EVENTS = TopicEnd("", "/parameter_events", "rcl_interfaces/msg/ParameterEvent")


class TopicTaps:
    """Records the topics that a backend publishes or receives, new ones from their first message.

    Any thread may use it.
    """

    def __init__(
        self,
        backend: Backend,
        recorder: Recorder,
        logger: RosbaseLogger,
        is_wanted: Callable[[str], bool] = lambda topic: True,
    ) -> None:
        """Prepare; `begin` begins to hear.

        Args:
            backend: Connection of the program.
            recorder: Takes the messages.
            logger: Says which topics cannot be recorded.
            is_wanted: Whether to record a topic of that full name.
        """
        self._backend, self._recorder, self._logger = backend, recorder, logger
        self._is_wanted = is_wanted
        self._taps: dict[str, Tap | None] = {}
        self._is_closed = False
        # A listener may log, and the log may be a new topic.
        self._lock = threading.RLock()

    def begin(self) -> None:
        """Hear the topics that there are, and each new one."""
        self._backend.new_ends.add(self._welcome)
        self.look()

    def look(self) -> None:
        """Hear the topics that are new. Raises nothing.

        `begin` does so too. Call it now and then, for backends that do not tell of new topics.
        """
        try:
            ends = _by_topic(self._backend.graph())
        except BackendError:
            # It is closed, or has no graph.
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
            self._logger.warning(f"{topic} is not recorded: {error}")
            return None

    def _hear(self, topic: str, ends: list[TopicEnd]) -> Tap:
        form = self._format(ends[0])
        metadata = _metadata(form, ends)
        record = self._recorder.channel(topic, form.type_name, form.schema, metadata)
        hear = _hearing(form.encode, record, self._backend.clock.now_ns, self._refuse(topic))
        if not any(end.profile is None or end.profile.is_latched for end in ends):
            # Nothing is kept, and a message costs one call less.
            return self._backend.add_tap(topic, hear)
        early: list[int] | None = []

        def first(message: Any) -> None:
            # What comes before the kept ones are known may be among them.
            if early is not None:
                early.append(id(message))
            hear(message)

        tap = self._backend.add_tap(topic, first)
        for message in self._backend.kept_messages(topic):
            if id(message) not in (early or ()):
                hear(message)
        early = None
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
                self._logger.warning(f"a message of {topic} is not recorded: {error}")

        return refuse


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
