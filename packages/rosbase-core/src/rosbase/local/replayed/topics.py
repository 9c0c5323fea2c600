"""Publishers that reach taps only, and subscriptions that hear the recording only."""

from collections.abc import Callable
from typing import Any, TypeAlias

from rosbase.contracts.tap import Tap
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind, Numbered
from rosbase.entries.script import Entry
from rosbase.errors import WireError
from rosbase.logger import RosbaseLogger
from rosbase.runtime.queued_subscription import QueuedSubscription
from rosbase.wire.values import name_of

__all__ = ["ReplayedPublisher", "ReplayedSubscription", "Taps"]

_LOG_S = 1.0

Taps: TypeAlias = dict[str, tuple[Tap, ...]]
"""The taps of each topic, by its full name."""


class ReplayedPublisher:
    """Writes messages of one class, and hands the bytes to the taps of one topic."""

    def __init__(
        self,
        conductor: Conductor,
        topic: str,
        msg_type: type,
        encode: Callable[[Any], bytes],
        taps: Taps,
    ) -> None:
        """Number the publisher.

        Args:
            conductor: The replay.
            topic: Its full name.
            msg_type: Class of its messages.
            encode: Writes one. TypeError or ValueError names a field that has no bytes.
            taps: The taps of all topics.
        """
        self.topic = topic
        self.msg_type = msg_type
        self._conductor, self._encode, self._taps = conductor, encode, taps
        self._is_closed = False
        self._number = conductor.number(Numbered.PUBLISHER, topic, self._replay)

    def publish(self, message: Any) -> bool:
        """Hand the message to taps. Another thread's message comes from the recording."""
        if not isinstance(message, self.msg_type):
            taken, given = name_of(self.msg_type), name_of(type(message))
            raise TypeError(f"{self.topic} takes {taken}, not {given}")
        data = self._encode(message)
        self._conductor.come_in(Kind.PUBLISH, (self._number,), data, lambda: self._send(data))
        return True

    @property
    def subscription_count(self) -> int:
        """Number of subscriptions that had found it."""
        count: Any = self._conductor.fact(int)
        return int(count)

    def close(self) -> None:
        """Stop sending."""
        self._is_closed = True

    def _replay(self, entry: Entry) -> None:
        self._send(entry.payload)

    def _send(self, data: bytes) -> None:
        if not self._is_closed:
            for tap in self._taps.get(self.topic, ()):
                tap.take(data)


class ReplayedSubscription(QueuedSubscription):
    """Messages of a recording, which wait for the callback as they did."""

    def __init__(
        self,
        conductor: Conductor,
        topic: str,
        callback: Callable[[Any], object],
        decode: Callable[[bytes], Any],
        schedule: Callable[[Callable[[], object]], None],
        logger: RosbaseLogger,
    ) -> None:
        """Number the subscription.

        Args:
            conductor: The replay.
            topic: Its full name.
            callback: Called with each message.
            decode: Reads one. WireError if it is none.
            schedule: Queues a call of the main loop.
            logger: Logs messages that cannot be read.
        """
        super().__init__(topic, self._take, 1, schedule)
        self._decode, self._handle, self._logger = decode, callback, logger
        conductor.number(Numbered.SUBSCRIPTION, topic, self._replay)

    def _replay(self, entry: Entry) -> None:
        self.deliver(entry.payload)

    def _take(self, data: bytes) -> None:
        try:
            message = self._decode(data)
        except WireError as error:
            line = f"{self.topic}: dropped a message: {error}"
            self._logger.log_throttle(line, _LOG_S, "warning")
            return
        self._handle(message)
