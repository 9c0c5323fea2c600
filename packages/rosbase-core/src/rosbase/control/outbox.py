"""The bytes that wait for a client to read them."""

import socket
from collections import deque

__all__ = ["Outbox"]

_CHUNK = 65_536
# A program may have given SIGPIPE back its default, which ends the process.
_NO_SIGNAL = getattr(socket, "MSG_NOSIGNAL", 0)


class Outbox:
    """Pieces of bytes in their order, and how many bytes they are together."""

    def __init__(self) -> None:
        self._pieces: deque[bytes | memoryview] = deque()
        self.size = 0
        """Number of bytes that wait."""

    def put(self, data: bytes) -> None:
        """Append a piece."""
        self._pieces.append(data)
        self.size += len(data)

    def put_frame(self, line: bytes, data: bytes) -> None:
        """Append a line and the bytes behind it."""
        # Joining costs less than two pieces do, as long as there is little to copy.
        if len(data) < _CHUNK:
            self.put(line + data)
        else:
            self.put(line)
            self.put(data)

    def clear(self) -> None:
        """Drop all pieces."""
        self._pieces.clear()
        self.size = 0

    def send(self, connection: socket.socket) -> None:
        """Send as much as the client takes now.

        Raises:
            OSError: The connection has ended.
        """
        while self._pieces:
            chunk = self._pieces[0] if len(self._pieces) == 1 else self._join()
            try:
                sent = connection.send(chunk, _NO_SIGNAL)
            except (BlockingIOError, InterruptedError):
                return
            self.size -= sent
            if sent == len(chunk):
                self._pieces.popleft()
            else:
                self._pieces[0] = memoryview(chunk)[sent:]

    def _join(self) -> bytes | memoryview:
        """Join the first pieces, so that many small ones are sent at once."""
        if len(self._pieces[0]) < _CHUNK:
            first: list[bytes | memoryview] = []
            size = 0
            while self._pieces and size < _CHUNK:
                first.append(self._pieces.popleft())
                size += len(first[-1])
            self._pieces.appendleft(b"".join(first))
        return self._pieces[0]
