"""One connection to a broker, from its beginning to its end.

All arriving data goes through a `PacketReader`. Messages are handed over and acknowledged here;
the session gets the rest. So nothing is kept, whatever a broker sends.
"""

import select
import ssl
from collections.abc import Callable
from typing import TypeAlias, cast

from imu_mqtt.buffered_socket import BufferedSocket, SocketWrapper
from imu_mqtt.config import MqttConfig
from imu_mqtt.dialing import DIAL_TIMEOUT_S, Dial, RefusedError, tls_context, unreachable
from imu_mqtt.packets import PINGRESP, PUBREL, Control, MalformedError, Message, PacketReader
from imu_mqtt.session import OFFLINE, ONLINE, Session
from imu_mqtt.websocket import WebSocket
from rosbase import Clock, DeviceNotFoundError, TransportError

__all__ = ["Connection", "OnMessage"]

OnMessage: TypeAlias = Callable[[Message], None]

ANSWER_TIMEOUT_S = 1.5
"""Timeout for each answer of the broker."""

# Waking up for each message costs more than the message. Where they come more often than so,
# they are left to gather for a moment.
_HURRIED_HZ = 1500
_WINDOW_NS = 100_000_000
_GATHER_S = 0.002
# In a turn, so that a flood keeps nobody from stopping.
_MOST_PACKETS = 100

_TURN_S = 0.05
_GOODBYE_S = 0.2
# How a message of each quality of service is acknowledged, and the release of one.
_ACKNOWLEDGED = {1: b"\x40\x02", 2: b"\x50\x02"}
_COMPLETED = b"\x70\x02"


class Connection:
    """A connection to one broker. Everything happens on the calling thread."""

    def __init__(
        self,
        config: MqttConfig,
        clock: Clock,
        on_message: OnMessage,
        is_wanted: Callable[[], bool],
        on_look: Callable[[], object] = lambda: None,
    ) -> None:
        """Prepare to connect.

        Args:
            config: Settings of the broker and the client.
            clock: For deadlines.
            on_message: Gets the messages. It must not raise.
            is_wanted: Called while an answer is awaited; returns whether to go on waiting.
            on_look: Called in each `turn` after polling the network, before anything is read.

        Raises:
            TransportError: The password or a certificate cannot be read.
        """
        self._config = config
        self._clock = clock
        self._on_message = on_message
        self._is_wanted = is_wanted
        self._is_awaiting = False
        self._on_look = on_look
        self._reader = PacketReader(is_5=config.version == "5")
        # Whether there may be whole packets in the reader.
        self._is_behind = False
        # Of QoS 2, by packet id: whether a message has been handed over and is not yet released.
        self._held = bytearray(65_536)
        self._poll = select.poll()
        self._wants = select.POLLIN
        self._packets, self._measured_ns, self._is_hurried = 0, clock.monotonic_ns(), False
        self._has_answered_ping = False
        # The time runs from here: a connection is made to be opened.
        dial = Dial(clock, is_wanted, DIAL_TIMEOUT_S)
        self._wrapper = SocketWrapper(tls_context(config), dial, _websocket(config))
        self._session = Session(config, lambda: dial.reach(config.address), self._wrapper)

    def open(self) -> None:
        """Connect, and wait some seconds at most for the broker's answer.

        Raises:
            RefusedError: The broker, or TLS, refuses.
            TransportError: There is no broker, or no answer.
        """
        failure = self._dial()
        if failure is not None:
            if self._wrapper.made is not None:
                self._wrapper.made.close()
            raise failure
        self._poll.register(self._socket, select.POLLIN)
        try:
            if not self._await(lambda: self._session.is_accepted):
                # Brokers for MQTT 3.1.1 alone are silent when they are greeted with 5.
                hint = "; does it speak MQTT 5?" if self._config.version == "5" else ""
                raise DeviceNotFoundError(f"no answer from {self._config.address}{hint}")
        except TransportError:
            self._session.disconnect()
            raise
        self._session.say(ONLINE)

    def watch(self, fd: int) -> None:
        """End `turn` also when that descriptor can be read."""
        self._poll.register(fd, select.POLLIN)

    def subscribe(self) -> None:
        """Subscribe, and wait for the broker's answer.

        Raises:
            RefusedError: The broker does not allow it.
            TransportError: The connection was lost meanwhile, or there is no answer.
        """
        topic, session = self._config.topic, self._session
        if not session.subscribe():
            raise TransportError(self.end)
        try:
            self._await(lambda: session.answer is not None)
        except TransportError as error:
            # A broker that does not like the topic may just hang up.
            raise TransportError(f"{error}, at the subscription to {topic}") from error
        if session.answer is None:
            raise TransportError(f"no answer to the subscription to {topic}")
        if len(session.answer) != 1:
            raise TransportError(f"{len(session.answer)} answers to the subscription to {topic}")
        (code,) = session.answer
        if code.is_failure:
            raise RefusedError(f"the broker refuses the subscription to {topic}: {code}")

    def unsubscribe(self) -> None:
        """Ask for no more messages, and wait a moment for the answer.

        A broker may take two requests that come together in any order.

        Raises:
            TransportError: The connection was lost meanwhile.
        """
        session = self._session
        if session.unsubscribe():
            self._await(lambda: session.answer is not None)

    def turn(self, timeout_s: float) -> bool:
        """Wait for work and do it; return whether the connection still stands.

        Raises:
            TransportError: The broker sends invalid data.
        """
        if self._session.is_over:
            return False
        sock = self._socket
        has_some = self._is_behind or sock.pending()
        events = self._await_event(sock, 0.0 if has_some else timeout_s)
        self._on_look()
        if not self._is_behind and (has_some or events & ~select.POLLOUT):
            self._reader.add(sock.fill(self._reader.room()))
            has_some = True
        if has_some:
            try:
                self._read(sock)
            except MalformedError as error:
                raise self._no_mqtt(error) from error
        sock.flush()
        if sock.is_stuck:
            raise TransportError(f"{self._config.address} does not read what it is sent")
        return self._session.keep_alive()

    def _await_event(self, sock: BufferedSocket, timeout_s: float) -> int:
        """Return the events of the network; if messages come fast, after a moment."""
        wants = select.POLLIN | (select.POLLOUT if sock.has_unsent else 0)
        if wants != self._wants:
            self._wants = wants
            self._poll.modify(sock, wants)
        events = dict(self._poll.poll(timeout_s * 1000.0)).get(sock.fileno(), 0)
        if events == select.POLLIN and self._is_hurried:
            self._clock.sleep(_GATHER_S)
        return events

    def _read(self, sock: BufferedSocket) -> None:
        """Read all data that has arrived, with a limit for a flood."""
        # And so it stays where the next packet is none.
        self._is_behind = True
        # Whoever awaits an answer takes it before what comes behind it.
        for _ in range(1 if self._is_awaiting else _MOST_PACKETS):
            packet = self._reader.take()
            if packet is None:
                self._is_behind = False
                break
            self._packets += 1
            if isinstance(packet, Message):
                self._take_message(packet, sock)
            else:
                self._take_control(packet, sock)
        self._measure_hurry()
        if sock.is_over and not self._is_behind:
            self._session.note_end()

    def _take_message(self, message: Message, sock: BufferedSocket) -> None:
        """Hand a message over, whatever its quality of service, and then acknowledge it.

        As the standard allows, messages of QoS 2 are handed over on arrival, not on
        release. So nothing is kept of a message that is never released.
        """
        qos, packet_id = message.qos, message.packet_id
        if qos == 2:
            if self._held[packet_id] and message.dup:
                message = message._replace(fault=message.fault or "duplicate")
            self._held[packet_id] = True
        self._on_message(message)
        if qos:
            sock.queue(_ACKNOWLEDGED[qos] + packet_id.to_bytes(2, "big"))

    def _take_control(self, packet: Control, sock: BufferedSocket) -> None:
        if packet.kind == PUBREL:
            self._held[packet.packet_id] = False
            sock.queue(_COMPLETED + packet.packet_id.to_bytes(2, "big"))
        elif packet.kind == PINGRESP:
            # One for each turn is enough, of however many.
            self._has_answered_ping = True
        else:
            self._session.take(packet)

    def _measure_hurry(self) -> None:
        """Measure how fast packets come, and note now and then that the broker is alive."""
        now_ns = self._clock.monotonic_ns()
        passed_ns = now_ns - self._measured_ns
        is_due = passed_ns >= _WINDOW_NS
        if is_due:
            self._is_hurried = self._packets * 1e9 > _HURRIED_HZ * passed_ns
            self._measured_ns, self._packets = now_ns, 0
        if is_due or self._has_answered_ping:
            self._has_answered_ping = False
            self._session.note_life()

    @property
    def end(self) -> str:
        """Reason why the connection ended, in one line."""
        return self._session.end or "the connection was lost"

    def close(self) -> None:
        """Say goodbye, if the network takes it at once, and disconnect."""
        try:
            self._say_goodbye()
        finally:
            self._session.disconnect()
            if self._wrapper.made is not None:
                # paho closes it when the broker does, which may be never.
                self._wrapper.made.close()

    def _say_goodbye(self) -> None:
        self._session.say(OFFLINE)
        deadline_ns = self._clock.monotonic_ns() + int(_GOODBYE_S * 1e9)
        made = self._wrapper.made
        try:
            while made and made.has_unsent and self._clock.monotonic_ns() < deadline_ns:
                if not self.turn(_TURN_S):
                    break
        except TransportError:
            # Whatever it was, it is over.
            pass

    def _dial(self) -> TransportError | None:
        """Connect; return why that failed, without the traceback, which would hold a socket."""
        try:
            self._session.connect()
        except Exception as error:
            return unreachable(self._config.address, error)
        return None

    @property
    def _socket(self) -> BufferedSocket:
        return cast(BufferedSocket, self._wrapper.made)

    def _no_mqtt(self, error: MalformedError) -> TransportError:
        """Return the message for a connection that ends with an invalid packet."""
        if self._session.is_accepted:
            return TransportError(f"{self._config.address} sends data that is not MQTT: {error}")
        return self._session.speaks_otherwise(str(error))

    def _lost(self) -> TransportError:
        failure = self._socket.failure
        if isinstance(failure, ssl.SSLError):
            return unreachable(self._config.address, failure)
        return TransportError(self.end)

    def _await(self, is_there: Callable[[], bool]) -> bool:
        """Wait for an answer of the broker; return whether it came in time."""
        self._is_awaiting = True
        try:
            return self._turn_until(is_there)
        finally:
            self._is_awaiting = False

    def _turn_until(self, is_there: Callable[[], bool]) -> bool:
        deadline_ns = self._clock.monotonic_ns() + int(ANSWER_TIMEOUT_S * 1e9)
        while not is_there():
            stands = self.turn(_TURN_S)
            if self._session.refusal is not None:
                raise self._session.refusal
            if not stands and not is_there():
                raise self._lost()
            if not self._is_wanted() or self._clock.monotonic_ns() > deadline_ns:
                return False
        return True


def _websocket(config: MqttConfig) -> WebSocket | None:
    address = config.address
    if address.scheme not in ("ws", "wss"):
        return None
    return WebSocket(address.place, address.path, is_secure=address.is_secure)
