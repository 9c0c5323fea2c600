"""Hear what a replayed program publishes and logs, as its recording did."""

import logging
from collections.abc import Callable, Iterable, Mapping
from threading import get_ident
from typing import Any

from rosbase import Backend, make_logger
from rosbase.entries.conductor import Conductor
from rosbase.entries.sink import EndFacts, RunFacts
from rosbase.entries.trace import Trace
from rosbase.logger.observer import add_observer, remove_observer
from rosbase_mcap.channel_table import ROS2MSG
from rosbase_mcap.log_channel import LOG_TOPIC, LogChannel
from rosbase_mcap.outputs import MASK
from rosbase_mcap.records import Schema
from rosbase_mcap.topic_taps import TopicTaps, wanted

__all__ = ["Listener"]


class Listener:
    """Hands on each message from within the program; it implements `RecordingSink`."""

    def __init__(
        self,
        topics: Iterable[str],
        declare: Callable[[str, Schema], object],
        hear: Callable[[int, str, int, bytes], object],
        *,
        on_begin: Callable[[Backend], object] = lambda backend: None,
    ) -> None:
        """Prepare.

        Args:
            topics: Full names of the topics; none stands for all.
            declare: Takes the schema of each topic, before its first message.
            hear: Takes each message: number of the entry, topic, `log_ns` and data, as `Output`
                has them.
            on_begin: Called with the connection of the program, before it has components.
        """
        self._topics = frozenset(topics)
        self._declare, self._hear, self._on_begin = declare, hear, on_begin

    def begin(self, backend: Any, conductor: Conductor, trace: Trace, facts: RunFacts) -> None:
        """Hear all topics of a program from now on."""
        self._conductor, self._trace = conductor, trace
        self._on_begin(backend)
        self._taps = TopicTaps(backend, self, make_logger("replay"), wanted(self._topics))
        self._taps.begin()
        self._log = LogChannel(self)
        if wanted(self._topics, log=True)(LOG_TOPIC):
            add_observer(self._take_line)

    def close(self, end: EndFacts) -> None:
        """Hear nothing any more."""
        self._taps.close()
        remove_observer(self._take_line)

    def _take_line(self, record: logging.LogRecord) -> None:
        # Lines of other threads come from the recording.
        if not getattr(record, "is_said_again", False):
            self._log.take(record)

    def channel(
        self, topic: str, type_name: str, schema: str, metadata: Mapping[str, str]
    ) -> Callable[[int, int, bytes], object]:
        """Return the function that takes a message of a topic; see `Channels`."""
        self._declare(topic, Schema(0, type_name, ROS2MSG, schema.encode()))
        turn, trace, hear = self._conductor.turn, self._trace, self._hear

        def take(log_ns: int, publish_ns: int, data: bytes) -> None:
            if turn.owner == get_ident():
                hear(trace.number & MASK, topic, log_ns, data)

        return take
