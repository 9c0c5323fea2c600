"""Messages that clients publish, into the programs."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from attrs import frozen
from foxglove.websocket import ClientChannel

from rosbase import ControlError
from rosbase.control.client import Connection
from rosbase.control.gathering import connect_to
from rosbase_view.foxglove.channels import Channels
from rosbase_view.foxglove.notices import Notices
from rosbase_view.foxglove.server import ENCODING
from rosbase_view.foxglove.worker import Worker
from rosbase_view.reports import Survey

__all__ = ["ClientTopics", "Publisher"]

Publisher = tuple[int, int]
"""Id of a client, and id of the channel that it publishes on."""

_ANSWER_S = 6.0
_MOST_WAITING = 1_000


@frozen
class _Offer:
    """A topic on which a client is about to publish."""

    topic: str
    type: str
    encoding: str


class ClientTopics:
    """Publishes for clients. Messages of one client stay in their order."""

    def __init__(
        self, channels: Channels, notices: Notices, on_failure: Callable[[Exception], object]
    ) -> None:
        """Begin without publishers.

        Args:
            channels: The topics by the names that clients see.
            notices: Takes the reasons why messages were not published.
            on_failure: Takes an error that should not happen.
        """
        self._channels, self._notices = channels, notices
        self._worker = Worker("rosbase view publishing", _MOST_WAITING, on_failure)
        self._survey = Survey((), {}, (), ())
        self._lock = threading.Lock()
        self._offers: dict[Publisher, _Offer] = {}
        # A publisher in a program lives as long as the connection that has made it.
        self._connections: dict[Publisher, Connection] = {}

    def start(self) -> None:
        """Start the thread that publishes."""
        self._worker.start()

    def close(self) -> None:
        """End the thread and all publishers."""
        self._worker.close()
        for connection in self._connections.values():
            connection.close()

    def update(self, survey: Survey) -> None:
        """Take what runs."""
        self._survey = survey

    def advertise(self, publisher: Publisher, channel: ClientChannel) -> None:
        """Learn what a client is about to publish."""
        offer = _Offer(channel.topic, channel.schema_name, channel.encoding)
        with self._lock:
            self._offers[publisher] = offer

    def unadvertise(self, publisher: Publisher) -> None:
        """End a publisher."""
        with self._lock:
            self._offers.pop(publisher, None)
        self._worker.add(partial(self._disconnect, publisher))

    def publish(self, publisher: Publisher, data: bytes) -> None:
        """Publish a message soon."""
        with self._lock:
            offer = self._offers.get(publisher)
        if offer is None:
            return
        if self._worker.add(partial(self._publish, publisher, offer, data)) is None:
            self._notices.say(
                _about(offer), f"messages for {offer.topic} come too fast: some are dropped"
            )

    # On the thread that publishes.

    def _publish(self, publisher: Publisher, offer: _Offer, data: bytes) -> None:
        try:
            self._send(publisher, offer, data)
        except ControlError as error:
            self._disconnect(publisher)
            self._notices.say(_about(offer), f"{offer.topic} is not published: {error}")
        else:
            self._tell_place(publisher, offer)

    def _tell_place(self, publisher: Publisher, offer: _Offer) -> None:
        """Tell a client whose topic no program has; it may have mistaken the name."""
        connection = self._connections.get(publisher)
        if connection is None or self._channels.key_of(offer.topic) is not None:
            self._notices.end(_about(offer))
            return
        text = f"no program has {offer.topic}: it is published in process {connection.pid}"
        self._notices.say(_about(offer), text)

    def _send(self, publisher: Publisher, offer: _Offer, data: bytes) -> None:
        """Publish a message, in the program that has the topic.

        Raises:
            ControlError: There is no such program, or it refuses the message.
        """
        if offer.encoding != ENCODING:
            raise ControlError(f"its encoding is {offer.encoding}, not {ENCODING}", "invalid")
        key = self._channels.key_of(offer.topic)
        connection = self._connections.get(publisher)
        if connection is None:
            connection = connect_to(self._place_of(offer.topic))
            self._connections[publisher] = connection
        arguments: dict[str, Any] = {
            "topic": offer.topic if key is None else key[0],
            "type": offer.type,
        }
        connection.ask("topic.publish", arguments, data, wait_s=_ANSWER_S)

    def _place_of(self, name: str) -> int:
        """Return the process in which to publish: where the topic is heard, if it is there.

        Raises:
            ControlError: No program runs, or several that may be meant.
        """
        key = self._channels.key_of(name)
        topic = None if key is None else self._survey.topics.get(key)
        if topic is not None:
            ends = topic["subscriptions"] or topic["publishers"]
            return min(end["pid"] for end in ends)
        pids = {process["pid"] for process in self._survey.processes}
        if len(pids) == 1:
            return pids.pop()
        if not pids:
            raise ControlError("no program runs", "unknown")
        raise ControlError("no program has the topic, and several run", "ambiguous")

    def _disconnect(self, publisher: Publisher) -> None:
        connection = self._connections.pop(publisher, None)
        if connection is not None:
            connection.close()


def _about(offer: _Offer) -> str:
    return f"publish {offer.topic}"
