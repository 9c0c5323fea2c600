"""What stands between paho and the network: a few large reads and writes instead of many small."""

import select
import socket
import ssl
from contextlib import suppress
from typing import Any

from imu_mqtt.dialing import Dial

__all__ = ["MOST_PACKET_BYTES", "BufferedSocket", "SocketWrapper"]

MOST_PACKET_BYTES = 2 * 65_536 + 1_024
"""Of a longer packet the middle is thrown away: twice the longest payload, and its topic."""

_READ_BYTES = 65_536


class _ThrownAway(bytes):
    """Tells paho that so many bytes were read, and holds none of them."""

    length: int

    def __len__(self) -> int:
        return self.length


class BufferedSocket:
    """As much of a socket as paho uses.

    paho reads a packet in four pieces, and in each of these system calls another thread may take
    over. Two threads that work hand in hand, one message after the other, then do so all the
    time, which costs more than whatever is done with a message.
    """

    def __init__(self, inner: socket.socket, dial: Dial, *, is_framed: bool) -> None:
        """Takes over a socket that is connected.

        Args:
            inner: The socket.
            dial: How long may be waited for what comes before MQTT.
            is_framed: Whether a WebSocket reads from it, and not MQTT itself.
        """
        self._inner = inner
        self._dial: Dial | None = dial
        self._is_framed = is_framed
        self._kept_bytes = self._still_long = 0
        # One buffer and exact copies keep the memory of the process flat.
        self._view = memoryview(bytearray(_READ_BYTES))
        self._start = self._end = 0
        self.failure: OSError | None = None
        """Why nothing more can be read; paho does not tell."""
        self._is_corked = False
        self._unsent = bytearray()
        self.fileno = inner.fileno

    def setblocking(self, flag: object) -> None:
        """Does nothing: it never waits but for what comes before MQTT, and then with a limit."""

    settimeout = setblocking

    def end_dialing(self) -> None:
        """What comes now is MQTT, and nothing is waited for."""
        self._dial = None

    def close(self) -> None:
        """Closes it; first, with TLS, looks why the other end has, which paho may not have read."""
        if isinstance(self._inner, ssl.SSLSocket) and self.failure is None:
            self._dial = None
            with suppress(OSError, ValueError):
                self._fill()
        self._inner.close()

    def pending(self) -> int:
        """How many bytes have been read from the network, and not by paho."""
        inner = self._inner
        # What TLS has decrypted, poll does not see.
        below = inner.pending() if isinstance(inner, ssl.SSLSocket) else 0
        return self._end - self._start + below

    def recv(self, size: int) -> bytes:
        """Some of what has arrived, `size` bytes at most. Raises what a socket does."""
        start, end = self._start, self._end
        if start == end:
            start, end = 0, self._fill()
        self._start, self._end = stop, _ = min(start + size, end), end
        if size > MOST_PACKET_BYTES:
            return self._take_of_long(size, start, stop)
        return self._view[start:stop].tobytes()

    def _take_of_long(self, size: int, start: int, stop: int) -> bytes:
        """Some of a packet of which so much is to come that it is not for us.

        paho would keep all of it. It gets the beginning, with the topic, and the end.
        """
        if self._is_framed:
            # A WebSocket keeps accounts of its own.
            self.failure = OSError(f"a message is longer than {MOST_PACKET_BYTES} bytes")
            raise self.failure
        if size >= self._still_long:
            # Within a packet it gets less and less, so this is another one.
            self._kept_bytes = 0
        self._still_long = size
        if self._kept_bytes < MOST_PACKET_BYTES:
            self._kept_bytes += stop - start
            return self._view[start:stop].tobytes()
        thrown = _ThrownAway()
        thrown.length = stop - start
        return thrown

    def _fill(self) -> int:
        while True:
            try:
                return self._inner.recv_into(self._view)
            except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
                if self._dial is None:
                    raise
                self._dial.wait(self._inner, select.POLLIN)
            except OSError as error:
                self.failure = error
                raise

    def send(self, data: bytes) -> int:
        """Sends some of it. Raises what a socket does."""
        if self._is_corked:
            self._unsent += data
            return len(data)
        self.flush()
        if self._unsent:
            raise BlockingIOError
        return self._inner.send(data)

    def cork(self) -> None:
        """Has `send` keep everything, until `flush`."""
        self._is_corked = True

    def flush(self) -> None:
        """Sends what was kept, as much as the network takes."""
        self._is_corked = False
        if self._unsent:
            try:
                del self._unsent[: self._inner.send(self._unsent)]
            except OSError:
                # The network is busy; or it is gone, and reading says so.
                pass

    @property
    def has_unsent(self) -> bool:
        """Whether the network has yet to take some of what was kept."""
        return bool(self._unsent)

    def do_handshake(self) -> None:
        """That of TLS, if it is used. Raises what a socket does."""
        if isinstance(self._inner, ssl.SSLSocket) and self._dial is not None:
            self._dial.shake_hands(self._inner)


class SocketWrapper:
    """What paho takes for a TLS context, because it asks that to wrap its socket."""

    check_hostname = True
    """Has paho leave that to the context behind this one."""

    def __init__(self, tls: ssl.SSLContext | None, dial: Dial, *, is_framed: bool) -> None:
        """Takes the context of a secure connection, and what a BufferedSocket takes."""
        self._tls = tls
        self._dial = dial
        self._is_framed = is_framed
        self.made: BufferedSocket | None = None
        """The socket that paho uses; a WebSocket stands between the two."""

    def wrap_socket(self, sock: socket.socket, server_hostname: str, **_: Any) -> BufferedSocket:
        """The socket that paho is to use."""
        if self._tls is not None:
            sock = self._tls.wrap_socket(
                sock, server_hostname=server_hostname, do_handshake_on_connect=False
            )
        sock.settimeout(0.0)
        self.made = BufferedSocket(sock, self._dial, is_framed=self._is_framed)
        return self.made
