"""The frames of the protocol: a line of JSON, and as many bytes behind it as it says.

Pure, and used by both sides. Whatever bytes come, only ControlError is raised.
"""

from __future__ import annotations

from rosbase.control.json_text import from_json, to_json
from rosbase.errors import ControlError

# Not from `typing`, which takes a command a third of the start of Python.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

__all__ = ["MOST_ANSWER", "MOST_PAYLOAD", "MOST_REQUEST", "FrameReader", "encode", "encode_line"]

MOST_REQUEST = 64 * 1024
"""Maximum length of the line of a request, in bytes."""
MOST_ANSWER = 16 * 1024 * 1024
"""Maximum length of the line of an answer, in bytes."""
MOST_PAYLOAD = 64 * 1024 * 1024
"""Maximum number of bytes behind a line."""


def encode(frame: dict[str, Any], payload: bytes = b"") -> bytes:
    """Return the bytes of a frame; `bytes` is added to it if there is a payload.

    Raises:
        ControlError: It cannot be written as JSON, or is too long.
    """
    return encode_line(frame, len(payload)) + payload


def encode_line(frame: dict[str, Any], size: int = 0) -> bytes:
    """Return the line of a frame with so many bytes behind it, and its line end.

    Raises:
        ControlError: It cannot be written as JSON, or is too long.
    """
    if size:
        frame = {**frame, "bytes": size}
    try:
        # Escapes stand for all but ASCII, so no line end is within it.
        line = to_json(frame).encode("ascii")
    except (TypeError, ValueError, RecursionError) as error:
        raise ControlError(f"it cannot be written as JSON: {error}", "invalid") from None
    if len(line) > MOST_ANSWER or size > MOST_PAYLOAD:
        raise ControlError(f"it is too long: {len(line)} and {size} bytes", "failed")
    return line + b"\n"


class FrameReader:
    """Takes bytes as they come, and returns whole frames. Its memory is bounded by the limits."""

    def __init__(self, most_line: int = MOST_ANSWER, most_payload: int = MOST_PAYLOAD) -> None:
        """Start without bytes. The limits are of one frame."""
        self._most_line = most_line
        self._most_payload = most_payload
        self._buffer = bytearray()
        # How far the buffer has been searched for a line end.
        self._searched = 0
        self._head: dict[str, Any] | None = None
        self._missing = 0
        self._fault: ControlError | None = None

    @property
    def held(self) -> int:
        """Number of bytes that wait for the rest of their frame."""
        return len(self._buffer)

    def feed(self, data: bytes) -> None:
        """Take the next bytes, in pieces of any size. Call `next` until it returns None."""
        if self._fault is None:
            self._buffer += data

    def next(self) -> tuple[dict[str, Any], bytes] | None:
        """Return the next whole frame: its line, and its payload; None if there is none yet.

        Raises:
            ControlError: The bytes are no frame. From then on, every call raises it.
        """
        if self._fault is not None:
            raise self._fault
        try:
            return self._next()
        except ControlError as error:
            self._fault = error
            self._buffer = bytearray()
            raise

    def _next(self) -> tuple[dict[str, Any], bytes] | None:
        if self._head is None:
            line = self._take_line()
            if line is None:
                return None
            self._head = parse_line(line)
            self._missing = self._size_in(self._head)
        if len(self._buffer) < self._missing:
            return None
        payload = self._take(self._missing)
        head, self._head, self._missing = self._head, None, 0
        return head, payload

    def _take_line(self) -> bytes | None:
        end = self._buffer.find(b"\n", self._searched, self._most_line + 1)
        if end < 0:
            if len(self._buffer) > self._most_line:
                raise ControlError(f"a line of more than {self._most_line} bytes", "invalid")
            self._searched = len(self._buffer)
            return None
        line = self._take(end)
        del self._buffer[:1]
        self._searched = 0
        return line

    def _take(self, size: int) -> bytes:
        taken = bytes(memoryview(self._buffer)[:size])
        del self._buffer[:size]
        return taken

    def _size_in(self, head: dict[str, Any]) -> int:
        size = head.get("bytes", 0)
        if type(size) is not int or size < 0:
            raise ControlError("`bytes` is a number of bytes", "invalid")
        if size > self._most_payload:
            raise ControlError(f"a payload of more than {self._most_payload} bytes", "invalid")
        return size


def parse_line(line: bytes) -> dict[str, Any]:
    """Return the object in a line of JSON.

    Raises:
        ControlError: It is something else.
    """
    try:
        found = from_json(line.decode("utf-8"))
    except (ValueError, RecursionError):
        raise ControlError("a line that is no JSON", "invalid") from None
    if not isinstance(found, dict):
        raise ControlError("a line that is no JSON object", "invalid")
    return found
