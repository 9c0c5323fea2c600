"""The client's side of a WebSocket (RFC 6455), as far as MQTT needs it. No I/O, bounded memory.

A frame is passed on as it comes, however long it is; of pings only the last is answered.
"""

import base64
import hashlib
import os
from collections.abc import Iterator

from rosbase import printable

__all__ = ["WebSocket", "WebSocketError"]

_GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
_MOST_ANSWER_BYTES = 8_192
_MOST_CONTROL_BYTES = 125
_CONTINUATION, _BINARY, _CLOSE, _PING, _PONG = 0x0, 0x2, 0x8, 0x9, 0xA
_FINAL, _MASKED = 0x80, 0x80


class WebSocketError(ValueError):
    """The server does not support WebSocket, or breaks its rules."""


class WebSocket:
    """One connection: the request and its answer, then frames in both directions."""

    def __init__(self, host: str, path: str, *, is_secure: bool) -> None:
        """Prepare the request.

        Args:
            host: Name and port of the server.
            path: Path of the request.
            is_secure: Whether there is TLS below it.
        """
        self._key = base64.b64encode(os.urandom(16))
        scheme = "https" if is_secure else "http"
        lines = (
            f"GET {path} HTTP/1.1",
            f"Host: {host}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Origin: {scheme}://{host}",
            f"Sec-WebSocket-Key: {self._key.decode()}",
            "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Protocol: mqtt",
        )
        self.request = ("\r\n".join(lines) + "\r\n\r\n").encode()
        """First data that the client sends."""
        self._answer = bytearray()
        # The head of a frame that has not arrived as a whole, or a control frame.
        self._head = bytearray()
        self._left_bytes = 0
        self._is_within = False
        self._ping: bytes | None = None
        self._close: bytes | None = None
        self.has_ended = False
        """Whether the server has closed the connection."""

    def take_answer(self, data: bytes) -> bytes | None:
        """Take a piece of the answer to the request.

        Returns:
            The data after the answer, once all of it is there; None before that.

        Raises:
            WebSocketError: It is not the answer of a server that speaks MQTT over a WebSocket.
        """
        self._answer += data
        end = self._answer.find(b"\r\n\r\n")
        if end < 0:
            if len(self._answer) > _MOST_ANSWER_BYTES:
                raise WebSocketError("an answer that does not end")
            return None
        first, *lines = bytes(self._answer[:end]).decode("latin-1").split("\r\n")
        if first.split(" ")[1:2] != ["101"]:
            raise WebSocketError(printable(first) or "an empty answer")
        named = (line.partition(":") for line in lines)
        fields = {name.strip().lower(): value.strip() for name, _, value in named}
        accepted = base64.b64encode(hashlib.sha1(self._key + _GUID).digest()).decode()
        if fields.get("sec-websocket-accept") != accepted:
            raise WebSocketError("an answer to another request")
        behind = bytes(self._answer[end + 4 :])
        self._answer.clear()
        return behind

    def feed(self, data: memoryview) -> Iterator[memoryview]:
        """Take arrived data; return the pieces of MQTT in it.

        Raises:
            WebSocketError: It breaks the rules of a WebSocket.
        """
        while data and not self.has_ended:
            if self._left_bytes:
                piece = data[: self._left_bytes]
                self._left_bytes -= len(piece)
                data = data[len(piece) :]
                yield piece
            else:
                data = self._take_head(data)

    def answers(self) -> bytes:
        """Return the frames that answer the data fed so far, once."""
        answer = b""
        if self._ping is not None:
            answer, self._ping = _frame(_PONG, self._ping), None
        if self._close is not None:
            answer, self._close = answer + _frame(_CLOSE, self._close), None
        return answer

    @staticmethod
    def frame(data: bytes) -> bytes:
        """Return a frame that carries the data."""
        return _frame(_BINARY, data)

    def _take_head(self, data: memoryview) -> memoryview:
        """Take some of the head of a frame, or all of a control frame."""
        head = self._head
        wanted = _head_bytes(head) - len(head)
        head += data[:wanted]
        if len(head) == 2:
            self._check(head[0], head[1])
        if len(head) == _head_bytes(head):
            self._begin(head)
            head.clear()
        return data[wanted:]

    def _check(self, first: int, second: int) -> None:
        """Refuse a frame that a server must not send, or no broker sends."""
        code, is_final = first & 0x0F, first & _FINAL
        if first & 0x70 or code not in (_CONTINUATION, _BINARY, _CLOSE, _PING, _PONG):
            raise WebSocketError(f"a WebSocket frame 0x{first:02x}, which carries no MQTT")
        if second & _MASKED:
            raise WebSocketError("a masked WebSocket frame")
        if code >= _CLOSE and (not is_final or second > _MOST_CONTROL_BYTES):
            raise WebSocketError("a WebSocket control frame that is too long or in pieces")
        if code < _CLOSE:
            if (code == _CONTINUATION) != self._is_within:
                raise WebSocketError("WebSocket frames in the wrong order")
            self._is_within = not is_final

    def _begin(self, head: bytearray) -> None:
        code = head[0] & 0x0F
        if code < _CLOSE:
            self._left_bytes = int.from_bytes(head[2:], "big") if head[1] > 125 else head[1]
        elif code == _PING:
            self._ping = bytes(head[2:])
        elif code == _CLOSE:
            self._close = bytes(head[2:])
            self.has_ended = True


def _head_bytes(head: bytearray) -> int:
    """Return the known length of a frame's head, or of a whole control frame."""
    if len(head) < 2:
        return 2
    length = head[1] & 0x7F
    if head[0] & 0x0F >= _CLOSE:
        return 2 + length
    return {126: 4, 127: 10}.get(length, 2)


def _frame(code: int, data: bytes) -> bytes:
    """Return a whole frame, masked, as a client must send it."""
    length = len(data)
    if length < 126:
        head = bytes([_FINAL | code, _MASKED | length])
    elif length < 65_536:
        head = bytes([_FINAL | code, _MASKED | 126]) + length.to_bytes(2, "big")
    else:
        head = bytes([_FINAL | code, _MASKED | 127]) + length.to_bytes(8, "big")
    key = os.urandom(4)
    mask = int.from_bytes((key * (length // 4 + 1))[:length], "big")
    return head + key + (int.from_bytes(data, "big") ^ mask).to_bytes(length, "big")
