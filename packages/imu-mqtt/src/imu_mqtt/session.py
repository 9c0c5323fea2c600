"""The dialogue with a broker: greeting, subscription, pings, status.

Only this module uses paho here.

paho's own thread is not used: a callback that raises would end it, it dials for ever, and nobody
can wake it. paho keeps everything that a broker sends, so it gets only the packets that it waits
for. Its callbacks only note events.
"""

import os
import socket
from collections.abc import Callable
from typing import Any, cast

import paho.mqtt.client as mqtt
from paho.mqtt.enums import CallbackAPIVersion, MQTTErrorCode, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from imu_mqtt.buffered_socket import BufferedSocket, SocketWrapper
from imu_mqtt.config import PASSWORD_VARIABLE, MqttConfig
from imu_mqtt.dialing import DIAL_TIMEOUT_S, RefusedError, words_of
from imu_mqtt.packets import MOST_PACKET_BYTES, PINGRESP, PUBACK, SUBACK, UNSUBACK, Control
from rosbase import TransportError, printable

__all__ = ["OFFLINE", "ONLINE", "Session"]

ONLINE, OFFLINE = b"online", b"offline"
"""Contents of the status topic, during a connection and after its end."""

_FOR_NOW = frozenset({"Server unavailable", "Server busy", "Connection rate exceeded"})
_MAX_QUEUED = 10


class _Client(mqtt.Client):
    """paho's client, on a given socket.

    paho's own way to connect has no time limit over all its steps, and for a Unix socket none
    at all. The two methods are not public. If paho drops them, it connects in its own way.
    """

    reach: Callable[[], socket.socket]
    """Returns the socket."""

    def _create_socket_connection(self) -> socket.socket:
        return self.reach()

    def _create_unix_socket_connection(self) -> socket.socket:
        return self.reach()


class Session:
    """Dialogue with one broker, and its answers."""

    def __init__(
        self, config: MqttConfig, reach: Callable[[], socket.socket], wrapper: SocketWrapper
    ) -> None:
        """Prepare to connect.

        Args:
            config: Settings of the client and the subscription.
            reach: Returns a socket that is connected to the broker.
            wrapper: Wraps that socket for paho.

        Raises:
            TransportError: The password cannot be read.
        """
        self._config = config
        self._wrapper = wrapper
        self._published: set[int] = set()
        self._asked: tuple[int, int] | None = None
        self.is_accepted = False
        """Whether the broker has accepted the client."""
        self.refusal: TransportError | None = None
        """Reason of a refusal."""
        self.answer: list[Any] | None = None
        """Codes of the broker's answer to the last request."""
        self.end = ""
        """Reason of the end, in one line; empty if it has not ended."""
        self._client = client = _client(config)
        client.reach = reach
        client.tls_set_context(cast(Any, wrapper))
        client.on_connect = self._on_connect
        client.on_disconnect = self._on_disconnect
        client.on_subscribe = client.on_unsubscribe = self._on_answer

    @property
    def is_over(self) -> bool:
        """Whether the connection has ended, or not begun."""
        return self._client.socket() is None

    def connect(self) -> None:
        """Connect and greet. Raise every error."""
        config = self._config
        self._client.connect(
            config.address.host,
            # Of a Unix socket paho wants one too, and does not use it.
            config.address.port or 1,
            config.keepalive_s,
            properties=_limits() if config.version == "5" else None,
        )

    def disconnect(self) -> None:
        """Say goodbye, if the network takes it at once, and close the socket. Idempotent."""
        self._client.disconnect()

    def subscribe(self) -> bool:
        """Ask for messages; `answer` will have the result. Return False if the session is over."""
        return self._ask(SUBACK, self._client.subscribe(self._config.topic, self._config.qos)[1])

    def unsubscribe(self) -> bool:
        """Ask for no more messages. Return False if the session is over."""
        return self._ask(UNSUBACK, self._client.unsubscribe(self._config.topic)[1])

    def say(self, status: bytes) -> None:
        """Publish a status, if there is a topic for it."""
        if self._config.status_topic and self.is_accepted and not self.is_over:
            topic = self._config.status_topic
            self._published.add(self._client.publish(topic, status, qos=1, retain=True).mid)

    def take(self, packet: Control) -> None:
        """Pass a packet to paho, if it waits for one like it.

        Others are dropped: an unexpected answer may just be late.
        """
        kind, packet_id, data = packet
        if kind in (SUBACK, UNSUBACK):
            if (kind, packet_id) != self._asked:
                return
            self._asked = None
        elif kind == PUBACK:
            if packet_id not in self._published:
                return
            self._published.remove(packet_id)
        self._feed(data)

    def note_life(self) -> None:
        """Tell paho that data has arrived, which may count as the answer to a ping."""
        if self.is_accepted:
            self._feed(bytes([PINGRESP, 0]))

    def note_end(self) -> None:
        """Tell paho that nothing more can be read."""
        self._feed(b"")

    def keep_alive(self) -> bool:
        """Ping if it is time; return whether the connection still stands."""
        return self._client.loop_misc() is MQTTErrorCode.MQTT_ERR_SUCCESS

    def speaks_otherwise(self, why: str = "") -> RefusedError:
        """Return the message and the reason where the first packet is invalid."""
        return RefusedError(
            f"{self._config.address} does not speak MQTT {self._config.version}"
            f"{why and f': {why}'}",
            "is it a WebSocket port (ws://), or does it speak another version (mqtt_version)?",
        )

    @property
    def _socket(self) -> BufferedSocket:
        return cast(BufferedSocket, self._wrapper.made)

    def _feed(self, data: bytes) -> None:
        if self.is_over:
            return
        self._socket.offer(data)
        try:
            self._client.loop_read()
        except Exception as error:
            # paho trusts the broker: of a packet that is none comes an error of any class.
            why = printable(repr(error))
            raise TransportError(
                f"{self._config.address} sends data that is not MQTT: {why}"
            ) from error

    def _ask(self, kind: int, packet_id: int | None) -> bool:
        if packet_id is None:
            return False
        self._asked, self.answer = (kind, packet_id), None
        return True

    # Called by paho, from within one of the above.

    def _on_connect(self, client: Any, data: Any, flags: Any, code: Any, properties: Any) -> None:
        if not code.is_failure:
            self.is_accepted = True
            return
        # A broker that has just been started, or has too much to do, will have time soon.
        kind = TransportError if str(code) in _FOR_NOW else RefusedError
        why = _explained(code, properties)
        self.refusal = kind(
            f"{self._config.address} refuses the connection{self._as_whom()}: {why}"
        )

    def _on_answer(
        self, client: Any, data: Any, mid: int, codes: list[Any], properties: Any
    ) -> None:
        self.answer = codes

    def _on_disconnect(
        self, client: Any, data: Any, flags: Any, code: Any, properties: Any
    ) -> None:
        address = self._config.address
        if flags.is_disconnect_packet_from_server:
            self.end = f"{address} ended the connection: {_explained(code, properties)}"
        elif not self.is_accepted:
            # With or without a reset, as it happens: for a user it is the same.
            hint = "" if address.is_secure else "; if it expects TLS, use mqtts:// or wss://"
            self.end = f"{address} closed the connection before it answered{hint}"
        else:
            failure = self._socket.failure
            reason = words_of(failure) if failure else str(code)
            # What paho says when the other end has closed it.
            why = "" if reason == "Unspecified error" else f": {reason}"
            self.end = f"the connection to {address} was lost{why}"
        if not self.is_accepted and self.refusal is None and str(code) == "Protocol error":
            self.refusal = self.speaks_otherwise()

    def _as_whom(self) -> str:
        client, variable = self._client, PASSWORD_VARIABLE
        if not client.username:
            is_set = bool(os.environ.get(variable))
            return f" without a username, which {variable} needs" if is_set else ""
        return f" as {client.username!r}" + ("" if client.password else " without a password")


def _client(config: MqttConfig) -> _Client:
    is_5 = config.version == "5"
    client = _Client(
        CallbackAPIVersion.VERSION2,
        client_id=config.client_id,
        # What was sent while we were away is old, and would be stamped as new.
        clean_session=None if is_5 else True,
        protocol=MQTTProtocolVersion.MQTTv5 if is_5 else MQTTProtocolVersion.MQTTv311,
        # A WebSocket is the affair of the socket that it is given.
        transport="unix" if config.address.scheme == "unix" else "tcp",
        reconnect_on_failure=False,
    )
    client.connect_timeout = DIAL_TIMEOUT_S
    client.max_queued_messages_set(_MAX_QUEUED)
    if config.username:
        client.username_pw_set(config.username, config.read_password())
    if config.status_topic:
        client.will_set(config.status_topic, OFFLINE, qos=1, retain=True)
    return client


def _limits() -> Properties:
    limits = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]  # paho's
    limits.MaximumPacketSize = MOST_PACKET_BYTES
    return limits


def _explained(code: object, properties: object) -> str:
    """Return the broker's reason for a code, with MQTT 5 in its own words."""
    words = str(getattr(properties, "ReasonString", ""))
    elsewhere = str(getattr(properties, "ServerReference", ""))
    text = f"{code} ({printable(words)})" if words else str(code)
    return f"{text}; it refers to {printable(elsewhere)}" if elsewhere else text
