"""The layer between paho and the network: large reads and writes, TLS, and a WebSocket."""

import socket
import ssl
from contextlib import suppress
from typing import Any

from imu_mqtt.dialing import Dial
from imu_mqtt.websocket import WebSocket, WebSocketError

__all__ = ["BufferedSocket", "SocketWrapper"]

_READ_BYTES = 65_536
# Answers to some thousand messages. A broker that does not take them has stopped reading.
_MOST_UNSENT_BYTES = 65_536


class BufferedSocket:
    """A connection that its owner reads, with the socket methods that paho uses.

    The owner reads arriving data with `fill`, and passes only paho's packets on with `offer`.
    paho alone would read each packet in four system calls, and keep everything that it
    receives.
    """

    def __init__(self, inner: socket.socket, dial: Dial, websocket: WebSocket | None) -> None:
        """Take over a connected socket.

        Args:
            inner: The socket.
            dial: Limits the time until MQTT begins.
            websocket: Carries the MQTT; None without a WebSocket.
        """
        self._inner = inner
        self._dial = dial
        self._websocket = websocket
        # Frames of a WebSocket, as they come.
        self._raw = memoryview(bytearray(_READ_BYTES if websocket else 0))
        self._early = b""
        self._offered = bytearray()
        self._unsent = bytearray()
        self.is_over = False
        """Whether nothing more can be read."""
        self.failure: Exception | None = None
        """Reason why nothing more can be read, if the other end has not just closed it."""
        self.fileno = inner.fileno

    def setblocking(self, flag: object) -> None:
        """Do nothing: the socket waits only before MQTT begins, and then with a limit."""

    settimeout = setblocking

    def do_handshake(self) -> None:
        """Run the handshakes before MQTT: TLS and the WebSocket's request, where they are used.

        Raises:
            OSError: The other end is gone, or does not answer in time.
            WebSocketError: The other end speaks no WebSocket.
        """
        if isinstance(self._inner, ssl.SSLSocket):
            self._dial.shake_hands(self._inner)
        if self._websocket is not None:
            self._dial.send(self._inner, self._websocket.request)
            self._early = self._await_answer(self._websocket)

    def _await_answer(self, websocket: WebSocket) -> bytes:
        while data := self._dial.receive(self._inner):
            early = websocket.take_answer(data)
            if early is not None:
                return early
        raise WebSocketError("it hung up")

    def pending(self) -> int:
        """Return the number of bytes that `poll` does not see."""
        inner = self._inner
        below = inner.pending() if isinstance(inner, ssl.SSLSocket) else 0
        return len(self._early) + below

    def fill(self, room: memoryview) -> int:
        """Read arrived data into `room`, as much as it takes, up to 64 KiB.

        Returns:
            The number of bytes of MQTT. It is 0 at the end too; then `is_over` is true.
        """
        try:
            if self._websocket is not None:
                return self._fill_from(self._websocket, room)
            count = self._inner.recv_into(room)
            self.is_over = not count
            return count
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return 0
        except (OSError, WebSocketError) as error:
            self.failure = error
            self.is_over = True
            return 0

    def _fill_from(self, websocket: WebSocket, room: memoryview) -> int:
        early, self._early = self._early, b""
        arrived = memoryview(early) or self._raw[: self._inner.recv_into(self._raw)]
        self.is_over = not arrived
        count = 0
        for piece in websocket.feed(arrived):
            room[count : count + len(piece)] = piece
            count += len(piece)
        self._unsent += websocket.answers()
        self.is_over |= websocket.has_ended
        return count

    def offer(self, packet: bytes) -> None:
        """Offer data for paho to read next."""
        self._offered += packet

    def recv(self, size: int) -> bytes:
        """Return some of the offered data. Called by paho; raises the errors of a socket."""
        if self._offered:
            data = bytes(self._offered[:size])
            del self._offered[:size]
            return data
        if not self.is_over:
            raise BlockingIOError
        if isinstance(self.failure, OSError):
            raise self.failure
        return b""

    def send(self, data: bytes) -> int:
        """Send all data, now or with the next `flush`. Called by paho."""
        self.queue(data)
        self.flush()
        return len(data)

    def queue(self, data: bytes) -> None:
        """Queue data for the next `flush`."""
        self._unsent += data if self._websocket is None else self._websocket.frame(data)

    def flush(self) -> None:
        """Send waiting data, as much as the network takes."""
        if self._unsent:
            try:
                del self._unsent[: self._inner.send(self._unsent)]
            except OSError:
                # The network is busy; or it is gone, and reading says so.
                pass

    @property
    def has_unsent(self) -> bool:
        """Whether some data has not been taken by the network yet."""
        return bool(self._unsent)

    @property
    def is_stuck(self) -> bool:
        """Whether the other end has stopped reading."""
        return len(self._unsent) > _MOST_UNSENT_BYTES

    def close(self) -> None:
        """Close the socket. With TLS, first read why the other end has closed it."""
        if isinstance(self._inner, ssl.SSLSocket) and not self.is_over:
            with suppress(ValueError):
                self.fill(memoryview(bytearray(_READ_BYTES)))
        self._inner.close()


class SocketWrapper:
    """Stands in for a TLS context, because paho asks that to wrap its socket."""

    check_hostname = True
    """False, so that paho leaves the check to the real context."""

    def __init__(
        self, tls: ssl.SSLContext | None, dial: Dial, websocket: WebSocket | None = None
    ) -> None:
        """Take the context of a secure connection, and the arguments of a BufferedSocket."""
        self._tls = tls
        self._dial = dial
        self._websocket = websocket
        self.made: BufferedSocket | None = None
        """Socket that paho uses."""

    def wrap_socket(self, sock: socket.socket, server_hostname: str, **_: Any) -> BufferedSocket:
        """Return the socket for paho."""
        if self._tls is not None:
            sock = self._tls.wrap_socket(
                sock, server_hostname=server_hostname, do_handshake_on_connect=False
            )
        sock.settimeout(0.0)
        self.made = BufferedSocket(sock, self._dial, self._websocket)
        return self.made
