"""A broker that does what the test says, well or badly, and who publishes to a real one."""

import socket
import threading
from collections.abc import Callable
from contextlib import suppress

import paho.mqtt.client as paho
from paho.mqtt.enums import CallbackAPIVersion

__all__ = [
    "GOOD",
    "Behaviour",
    "Peer",
    "Publisher",
    "ScriptedBroker",
    "ends_after_connack",
    "falls_silent",
    "publish_packet",
    "refuses",
    "refuses_subscriptions",
    "says_nothing",
    "sends",
    "serves",
]

CONNACK, PUBLISH, PUBACK, SUBACK, UNSUBACK, PINGRESP = 0x20, 0x30, 0x40, 0x90, 0xB0, 0xD0
CONNECT, SUBSCRIBE, UNSUBSCRIBE, PINGREQ, DISCONNECT = 0x10, 0x82, 0xA2, 0xC0, 0xE0


def packet(kind: int, body: bytes = b"") -> bytes:
    """A packet with its length, as MQTT 3.1.1 writes it."""
    length, rest = bytearray(), len(body)
    while True:
        rest, low = rest >> 7, rest & 0x7F
        length.append(low | (0x80 if rest else 0))
        if not rest:
            return bytes([kind, *length]) + body


def publish_packet(
    topic: bytes, payload: bytes, *, retain: bool = False, duplicate: bool = False
) -> bytes:
    """A message, at QoS 1 if it is a duplicate."""
    kind = PUBLISH | retain | (0x0A if duplicate else 0)
    mid = b"\0\7" if duplicate else b""
    return packet(kind, len(topic).to_bytes(2, "big") + topic + mid + payload)


GOOD = publish_packet(b"esp32/imu", b"good")
"""A message."""


class Peer:
    """One client's connection, as the broker sees it."""

    def __init__(self, sock: socket.socket) -> None:
        self._sock = sock
        self._stream = sock.makefile("rb")
        # What is published must not come between the halves of an answer.
        self._lock = threading.Lock()
        self._is_closed = threading.Event()
        self.is_let_in = False
        """Whether the client's greeting has been answered: nothing goes before that."""

    def send(self, data: bytes) -> None:
        with self._lock:
            self._sock.sendall(data)

    def receive(self) -> tuple[int, bytes]:
        """The next packet's first byte and body. Raises EOFError when there is none."""
        kind, length, shift = self.read(1)[0], 0, 0
        while True:
            byte = self.read(1)[0]
            length |= (byte & 0x7F) << shift
            shift += 7
            if not byte & 0x80:
                return kind, self.read(length)

    def accept(self, code: int = 0) -> None:
        """Answers the client's CONNECT."""
        kind, _ = self.receive()
        assert kind == CONNECT
        self.send(packet(CONNACK, bytes([0, code])))
        self.is_let_in = True

    def serve(self, *, until: int | None = None) -> None:
        """Answers what a client asks, up to the first packet of that kind, answered too."""
        while True:
            kind, body = self.receive()
            answers = {
                SUBSCRIBE: packet(SUBACK, body[:2] + b"\0"),
                UNSUBSCRIBE: packet(UNSUBACK, body[:2]),
                PINGREQ: packet(PINGRESP),
                PUBLISH | 2: packet(PUBACK, body[:2]),
            }
            self.send(answers.get(kind, b""))
            if kind in (until, DISCONNECT):
                return

    def wait_for_the_end(self) -> None:
        """Reads, and answers nothing, until the client has gone."""
        while self._stream.read1(65_536):
            pass

    def pause(self, seconds: float) -> None:
        """Does nothing for a while. Raises EOFError when the connection is closed here."""
        if self._is_closed.wait(seconds):
            raise EOFError

    def shrink(self) -> None:
        """Takes little from now on, if nobody reads."""
        self._sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4_096)

    def close(self) -> None:
        self._is_closed.set()
        try:
            self._sock.shutdown(socket.SHUT_RDWR)
        except OSError:
            # The client was faster.
            pass

    def release(self) -> None:
        self.close()
        self._stream.close()
        self._sock.close()

    def read(self, size: int) -> bytes:
        """So many bytes. Raises EOFError when there are no more."""
        data = self._stream.read(size)
        if len(data) < size:
            raise EOFError
        return data


Behaviour = Callable[[Peer], None]
"""What a broker does with one connection, which ends when it returns."""


def serves(peer: Peer) -> None:
    """As a good broker without publishers."""
    peer.accept()
    peer.serve()


def says_nothing(peer: Peer) -> None:
    """Takes the connection and never answers."""
    peer.wait_for_the_end()


def ends_after_connack(peer: Peer) -> None:
    """Takes the client, and then does not want it."""
    peer.accept()


def falls_silent(peer: Peer) -> None:
    """Subscribes, then is as behind a cable that was cut."""
    peer.accept()
    peer.serve(until=SUBSCRIBE)
    peer.wait_for_the_end()


def refuses_subscriptions(peer: Peer) -> None:
    """Lets the client in, and lets it read nothing."""
    peer.accept()
    kind, body = peer.receive()
    assert kind == SUBSCRIBE
    peer.send(packet(SUBACK, body[:2] + b"\x80"))
    peer.serve()


def refuses(code: int) -> Behaviour:
    """Takes no client, and says so with this code of MQTT 3.1.1."""
    return lambda peer: peer.accept(code)


def sends(*data: bytes) -> Behaviour:
    """Sends this after the subscription, and goes on as a good broker does."""

    def behave(peer: Peer) -> None:
        peer.accept()
        peer.serve(until=SUBSCRIBE)
        for part in data:
            peer.send(part)
        peer.serve()

    return behave


class ScriptedBroker:
    """Listens on a port of this machine, and treats each connection as the test says."""

    def __init__(self, behaviour: Behaviour = serves, port: int = 0, path: str = "") -> None:
        self.behaviour = behaviour
        """That of the connections from now on."""
        self.dials = 0
        self._path = path
        if path:
            self._server = socket.socket(socket.AF_UNIX)
            self._server.bind(path)
            self._server.listen()
        else:
            self._server = socket.create_server(("127.0.0.1", port))
        self.port: int = 0 if path else self._server.getsockname()[1]
        self.peers: list[Peer] = []
        """Those that are connected."""
        self._lock = threading.Lock()
        self._threads = [threading.Thread(target=self._accept)]
        self._threads[0].start()

    @property
    def address(self) -> str:
        return f"unix://{self._path}" if self._path else f"tcp://127.0.0.1:{self.port}"

    def send(self, data: bytes) -> None:
        """Sends to everybody who has been let in."""
        for peer in list(self.peers):
            if peer.is_let_in:
                # It may have gone, and nobody has noticed yet.
                with suppress(OSError):
                    peer.send(data)

    def drop(self) -> None:
        """Ends all connections."""
        for peer in list(self.peers):
            peer.close()

    def close(self) -> None:
        """Ends everything. Idempotent."""
        with self._lock:
            # Wakes `accept`, as closing alone does not.
            if self._server.fileno() >= 0:
                self._server.shutdown(socket.SHUT_RDWR)
            self._server.close()
            self.drop()
        for thread in self._threads:
            thread.join(10)

    def __enter__(self) -> "ScriptedBroker":
        return self

    def __exit__(self, *details: object) -> None:
        self.close()

    def _accept(self) -> None:
        while True:
            try:
                sock, _ = self._server.accept()
            except OSError:
                return
            self.dials += 1
            with self._lock:
                peer = Peer(sock)
                if self._server.fileno() < 0:
                    peer.release()
                    return
                self.peers.append(peer)
                self._threads.append(threading.Thread(target=self._behave, args=(peer,)))
                self._threads[-1].start()

    def _behave(self, peer: Peer) -> None:
        try:
            self.behaviour(peer)
        except (EOFError, OSError):
            # The client has gone.
            pass
        finally:
            self.peers.remove(peer)
            peer.release()


class Publisher:
    """A client of paho's that publishes to a broker on this machine."""

    def __init__(self, port: int) -> None:
        self._client: paho.Client | None = paho.Client(CallbackAPIVersion.VERSION2)
        self._client.connect("127.0.0.1", port)
        self._client.loop_start()

    def publish(
        self, payload: bytes, topic: str = "esp32/imu", *, qos: int = 1, retain: bool = False
    ) -> None:
        """Returns when the broker has it."""
        assert self._client is not None
        info = self._client.publish(topic, payload, qos, retain)
        info.wait_for_publish(10)
        assert info.is_published(), "the broker did not take it"

    def close(self) -> None:
        """Idempotent."""
        if self._client is not None:
            self._client.disconnect()
            self._client.loop_stop()
        # paho closes the last of its sockets when it is no longer there.
        self._client = None

    def __enter__(self) -> "Publisher":
        return self

    def __exit__(self, *details: object) -> None:
        self.close()
