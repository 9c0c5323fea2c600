"""One connection to a broker, from its beginning to its end: the one module that touches paho.

paho has a thread of its own to offer, which a callback that raises would end, which dials for
ever, and which nobody can wake. Here it has none: whoever owns the connection calls `turn`, and
paho's callbacks only note what happened.
"""

import os
import select
import socket
import ssl
from collections.abc import Callable
from typing import Any, TypeAlias, cast

import paho.mqtt.client as mqtt
from paho.mqtt.enums import CallbackAPIVersion, MQTTErrorCode, MQTTProtocolVersion
from paho.mqtt.packettypes import PacketTypes
from paho.mqtt.properties import Properties

from imu_mqtt.buffered_socket import MOST_PACKET_BYTES, BufferedSocket, SocketWrapper
from imu_mqtt.config import PASSWORD_VARIABLE, MqttConfig
from imu_mqtt.dialing import Dial, RefusedError, one_line, tls_context, unreachable
from rosbase import Clock, DeviceNotFoundError, TransportError

__all__ = ["Connection", "OnMessage"]

OnMessage: TypeAlias = Callable[[mqtt.MQTTMessage], None]

DIAL_TIMEOUT_S = 2.0
"""How long it may take to reach the broker, TLS and WebSocket included."""
ANSWER_TIMEOUT_S = 1.5
"""How long the broker may take for each answer."""

# Waking up for each message costs more than the message. Where they come more often than so,
# they are left to gather for a moment.
_HURRIED_HZ = 1500
_WINDOW_NS = 100_000_000
_GATHER_S = 0.002
_MOST_PACKETS = 100

_TURN_S = 0.05
_GOODBYE_S = 0.2
_TRANSPORTS = {"ws": "websockets", "wss": "websockets", "unix": "unix"}
_FOR_NOW = frozenset({"Server unavailable", "Server busy", "Connection rate exceeded"})
_ONLINE, _OFFLINE = b"online", b"offline"
_MAX_QUEUED = 10


class _Client(mqtt.Client):
    """paho's client, on a socket that is given to it.

    paho's own connecting has no limit over all its steps, and for a Unix socket none at all. The
    two methods are not public: should paho do without them, it connects as it does by itself.
    """

    reach: Callable[[], socket.socket]
    """Gives the socket."""

    def _create_socket_connection(self) -> socket.socket:
        return self.reach()

    def _create_unix_socket_connection(self) -> socket.socket:
        return self.reach()


class Connection:
    """Talks to one broker. Everything happens on the thread that calls."""

    def __init__(
        self,
        config: MqttConfig,
        clock: Clock,
        on_message: OnMessage,
        is_wanted: Callable[[], bool],
    ) -> None:
        """Prepares to connect.

        Args:
            config: To which broker, and as whom.
            clock: For stamps and deadlines.
            on_message: Gets the messages. It must not raise.
            is_wanted: Asked while an answer is awaited: whether to go on waiting.

        Raises:
            TransportError: The password or a certificate cannot be read.
        """
        self._config = config
        self._clock = clock
        self._is_wanted = is_wanted
        self._refusal: TransportError | None = None
        self._is_accepted = self._is_awaiting = False
        self._answers: dict[int, list[Any]] = {}
        self._end = ""
        self.arrived_ns = 0
        """When what is being read could be read, in nanoseconds since the epoch."""
        self._poll = select.poll()
        self._wants = select.POLLIN
        self._packets, self._measured_ns, self._is_hurried = 0, clock.monotonic_ns(), False
        self._client = client = _client(config)
        tls = tls_context(config)
        # The time runs from here: a connection is made to be opened.
        dial = Dial(clock, is_wanted, DIAL_TIMEOUT_S)
        self._wrapper = SocketWrapper(tls, dial, is_framed=client.transport == "websockets")
        client.reach = lambda: dial.reach(config.address)
        client.tls_set_context(cast(Any, self._wrapper))
        client.on_connect = self._on_connect
        client.on_disconnect = self._on_disconnect
        client.on_subscribe = client.on_unsubscribe = self._on_answer
        client.on_message = lambda _client, _data, message: on_message(message)

    def open(self) -> None:
        """Connects, and waits for the broker's answer; some seconds at most.

        Raises:
            RefusedError: The broker, or TLS, refuses.
            TransportError: There is no broker, or no answer.
        """
        failure = self._dial()
        if failure is not None:
            if self._wrapper.made is not None:
                self._wrapper.made.close()
            raise failure
        if self._client.socket() is None:
            # The broker has hung up at once, and paho too.
            raise self._lost()
        self._poll.register(self._socket, select.POLLIN)
        try:
            if not self._await(lambda: self._is_accepted):
                # Brokers for MQTT 3.1.1 alone are silent when they are greeted with 5.
                hint = "; does it speak MQTT 5?" if self._config.version == "5" else ""
                raise DeviceNotFoundError(f"no answer from {self._config.address}{hint}")
        except TransportError:
            self._client.disconnect()
            raise
        if self._config.status_topic:
            self._say(_ONLINE)

    def watch(self, fd: int) -> None:
        """Has `turn` end when that descriptor can be read, too."""
        self._poll.register(fd, select.POLLIN)

    def subscribe(self) -> None:
        """Subscribes, and waits for the broker's answer.

        Raises:
            RefusedError: The broker does not allow it.
            TransportError: The connection was lost meanwhile, or there is no answer.
        """
        topic = self._config.topic
        _, mid = self._client.subscribe(topic, self._config.qos)
        if mid is None:
            raise TransportError(self._end or "the connection was lost")
        try:
            is_answered = self._await(lambda: mid in self._answers)
        except TransportError as error:
            # A broker that does not like the topic may just hang up.
            raise TransportError(f"{error}, at the subscription to {topic}") from error
        if not is_answered:
            raise TransportError(f"no answer to the subscription to {topic}")
        for code in self._answers.pop(mid):
            if code.is_failure:
                raise RefusedError(f"the broker refuses the subscription to {topic}: {code}")

    def unsubscribe(self) -> None:
        """Asks for no more messages, and waits a moment for the answer.

        A broker may take two requests that come together in any order.

        Raises:
            TransportError: The connection was lost meanwhile.
        """
        _, mid = self._client.unsubscribe(self._config.topic)
        if mid is not None:
            self._await(lambda: mid in self._answers)
            self._answers.pop(mid, None)

    def turn(self, timeout_s: float) -> bool:
        """Waits for something to do and does it; tells whether the connection still stands.

        Raises:
            TransportError: What the broker sends makes no sense.
        """
        client = self._client
        if client.socket() is None:
            return False
        events = self._await_event(0.0 if self._socket.pending() else timeout_s)
        self.arrived_ns = self._clock.now_ns()
        try:
            if self._socket.pending() or events & ~select.POLLOUT:
                self._read()
            if events & select.POLLOUT:
                self._socket.flush()
                client.loop_write()
            return client.loop_misc() is MQTTErrorCode.MQTT_ERR_SUCCESS
        except Exception as error:
            # paho trusts the broker: of a packet that is none comes an error of any class.
            raise TransportError(f"{self._config.address} sends no MQTT: {error!r}") from error

    def _await_event(self, timeout_s: float) -> int:
        """What the network is ready for; where messages come in a hurry, after a moment."""
        is_blocked = self._client.want_write() or self._socket.has_unsent
        wants = select.POLLIN | (select.POLLOUT if is_blocked else 0)
        if wants != self._wants:
            self._wants = wants
            self._poll.modify(self._socket, wants)
        events = dict(self._poll.poll(timeout_s * 1000.0)).get(self._socket.fileno(), 0)
        if events == select.POLLIN and self._is_hurried:
            self._clock.sleep(_GATHER_S)
        return events

    def _read(self) -> None:
        """Has paho take what has arrived, all of it but for a flood."""
        sock = self._socket
        sock.cork()
        # Whoever awaits an answer takes it before what comes behind it.
        for _ in range(1 if self._is_awaiting else _MOST_PACKETS):
            self._client.loop_read()
            self._packets += 1
            if not sock.pending():
                break
        sock.flush()
        self._measure_hurry()

    def _measure_hurry(self) -> None:
        now_ns = self._clock.monotonic_ns()
        passed_ns = now_ns - self._measured_ns
        if passed_ns >= _WINDOW_NS:
            self._is_hurried = self._packets * 1e9 > _HURRIED_HZ * passed_ns
            self._measured_ns, self._packets = now_ns, 0

    @property
    def end(self) -> str:
        """Why it ended, in one line."""
        return self._end or "the connection was lost"

    def close(self) -> None:
        """Says goodbye, if the network takes it at once, and disconnects."""
        try:
            self._say_goodbye()
        finally:
            self._client.disconnect()
            if self._wrapper.made is not None:
                # paho closes it when the broker does, which may be never.
                self._wrapper.made.close()

    def _say_goodbye(self) -> None:
        if self._config.status_topic and self._client.is_connected():
            self._say(_OFFLINE)
        deadline_ns = self._clock.monotonic_ns() + int(_GOODBYE_S * 1e9)
        try:
            while self._client.want_write() and self._clock.monotonic_ns() < deadline_ns:
                if not self.turn(_TURN_S):
                    break
        except TransportError:
            # Whatever it was, it is over.
            pass

    def _dial(self) -> TransportError | None:
        """Connects; gives why that failed, without the traceback, for it holds a socket."""
        address = self._config.address
        try:
            self._client.connect(
                address.host,
                # Of a Unix socket paho wants one too, and does not use it.
                address.port or 1,
                self._config.keepalive_s,
                properties=_limits() if self._config.version == "5" else None,
            )
        except Exception as error:
            # paho trusts a WebSocket's answer: of one that it cannot read comes any error.
            return unreachable(address, error)
        if self._wrapper.made is not None:
            self._wrapper.made.end_dialing()
        return None

    @property
    def _socket(self) -> "BufferedSocket":
        return cast("BufferedSocket", self._wrapper.made)

    def _lost(self) -> TransportError:
        failure = self._socket.failure
        if isinstance(failure, ssl.SSLError):
            return unreachable(self._config.address, failure)
        return TransportError(self.end)

    def _say(self, status: bytes) -> None:
        self._client.publish(self._config.status_topic, status, qos=1, retain=True)

    def _await(self, is_there: Callable[[], bool]) -> bool:
        """Waits for an answer of the broker's; tells whether it came in time."""
        self._is_awaiting = True
        try:
            return self._turn_until(is_there)
        finally:
            self._is_awaiting = False

    def _turn_until(self, is_there: Callable[[], bool]) -> bool:
        deadline_ns = self._clock.monotonic_ns() + int(ANSWER_TIMEOUT_S * 1e9)
        while not is_there():
            stands = self.turn(_TURN_S)
            if self._refusal is not None:
                raise self._refusal
            if not stands and not is_there():
                raise self._lost()
            if not self._is_wanted() or self._clock.monotonic_ns() > deadline_ns:
                return False
        return True

    # Called by paho, from within `turn`.

    def _on_connect(self, client: Any, data: Any, flags: Any, code: Any, properties: Any) -> None:
        if code.is_failure:
            # A broker that has just been started, or has too much to do, will have time soon.
            kind = TransportError if str(code) in _FOR_NOW else RefusedError
            self._refusal = kind(f"{self._config.address} refuses us{self._as_whom()}: {code}")
        else:
            self._is_accepted = True

    def _on_disconnect(
        self, client: Any, data: Any, flags: Any, code: Any, properties: Any
    ) -> None:
        address = self._config.address
        if flags.is_disconnect_packet_from_server:
            self._end = f"{address} ended the connection: {code}"
        elif not self._is_accepted:
            # With or without a reset, as it happens: for a user it is the same.
            hint = "" if address.is_secure else "; if it expects TLS, say mqtts:// or wss://"
            self._end = f"{address} hung up before it answered{hint}"
        else:
            failure = self._socket.failure
            reason = one_line(failure) if failure else str(code)
            # What paho says when the other end has closed it.
            why = "" if reason == "Unspecified error" else f": {reason}"
            self._end = f"the connection to {address} was lost{why}"
        if not self._is_accepted and self._refusal is None and str(code) == "Protocol error":
            self._refusal = RefusedError(
                f"{address} speaks no MQTT {self._config.version}",
                "is it the port of a WebSocket (ws://), or of another version (mqtt_version)?",
            )

    def _as_whom(self) -> str:
        client, variable = self._client, PASSWORD_VARIABLE
        if not client.username:
            is_set = bool(os.environ.get(variable))
            return f" without a username, which {variable} needs" if is_set else ""
        return f" as {client.username!r}" + ("" if client.password else " without a password")

    def _on_answer(
        self, client: Any, data: Any, mid: int, codes: list[Any], properties: Any
    ) -> None:
        self._answers[mid] = codes


def _client(config: MqttConfig) -> _Client:
    is_5 = config.version == "5"
    client = _Client(
        CallbackAPIVersion.VERSION2,
        client_id=config.client_id,
        # What was sent while we were away is old, and would be stamped as new.
        clean_session=None if is_5 else True,
        protocol=MQTTProtocolVersion.MQTTv5 if is_5 else MQTTProtocolVersion.MQTTv311,
        transport=cast(Any, _TRANSPORTS.get(config.address.scheme, "tcp")),
        reconnect_on_failure=False,
    )
    client.connect_timeout = DIAL_TIMEOUT_S
    client.max_queued_messages_set(_MAX_QUEUED)
    if client.transport == "websockets":
        # paho would say https, because it is given a TLS context.
        scheme = "https" if config.address.is_secure else "http"
        origin = f"{scheme}://{config.address.host}:{config.address.port}"
        client.ws_set_options(config.address.path, {"Origin": origin})
    if config.username:
        client.username_pw_set(config.username, config.read_password())
    if config.status_topic:
        client.will_set(config.status_topic, _OFFLINE, qos=1, retain=True)
    return client


def _limits() -> Properties:
    limits = Properties(PacketTypes.CONNECT)  # type: ignore[no-untyped-call]  # paho's
    limits.MaximumPacketSize = MOST_PACKET_BYTES
    return limits
