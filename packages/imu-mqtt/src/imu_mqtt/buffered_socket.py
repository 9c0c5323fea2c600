"""What stands between paho and the network: a few large reads and writes instead of many small."""

import socket
import ssl
from contextlib import suppress
from typing import Any

__all__ = ["BufferedSocket", "SocketWrapper"]

_READ_BYTES = 65_536


class BufferedSocket:
    """As much of a socket as paho uses.

    paho reads a packet in four pieces, and in each of these system calls another thread may take
    over. Two threads that work hand in hand, one message after the other, then do so all the
    time, which costs more than whatever is done with a message.
    """

    def __init__(self, inner: socket.socket) -> None:
        """Takes over a socket that is connected."""
        self._inner = inner
        # One buffer and exact copies keep the memory of the process flat.
        self._view = memoryview(bytearray(_READ_BYTES))
        self._start = self._end = 0
        self.failure: OSError | None = None
        """Why nothing more can be read; paho does not tell."""
        self._is_corked = False
        self._unsent = bytearray()
        self.fileno = inner.fileno
        self.setblocking = inner.setblocking
        self.settimeout = inner.settimeout

    def close(self) -> None:
        """Closes it; first, with TLS, looks why the other end has, which paho may not have read."""
        if isinstance(self._inner, ssl.SSLSocket) and self.failure is None:
            with suppress(OSError, ValueError):
                self._inner.settimeout(0.0)
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
        return self._view[start:stop].tobytes()

    def _fill(self) -> int:
        try:
            return self._inner.recv_into(self._view)
        except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
            raise
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
        if isinstance(self._inner, ssl.SSLSocket):
            self._inner.do_handshake()


class SocketWrapper:
    """What paho takes for a TLS context, because it asks that to wrap its socket."""

    check_hostname = True
    """Has paho leave that to the context behind this one."""

    def __init__(self, tls: ssl.SSLContext | None) -> None:
        """Takes the context of a secure connection."""
        self._tls = tls
        self.made: BufferedSocket | None = None
        """The socket that paho uses; a WebSocket stands between the two."""

    def wrap_socket(self, sock: socket.socket, server_hostname: str, **_: Any) -> BufferedSocket:
        """The socket that paho is to use."""
        if self._tls is not None:
            sock = self._tls.wrap_socket(
                sock, server_hostname=server_hostname, do_handshake_on_connect=False
            )
        self.made = BufferedSocket(sock)
        return self.made
