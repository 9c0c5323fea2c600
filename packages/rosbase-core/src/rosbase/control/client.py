"""A connection to the control socket of one program.

A command that asks a program is over in some milliseconds, so each import counts: `socket` alone
takes a third of the time in which Python starts, and this needs only its C part.
"""

from __future__ import annotations

import select
from _socket import AF_UNIX, SOCK_STREAM, socket

from rosbase.control.frames import FrameReader, encode
from rosbase.control.time_limit import TimeLimit
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import Any

__all__ = ["PROTOCOL", "Connection", "Stream", "error_in"]

PROTOCOL = 1
_CHUNK = 256 * 1024


class Connection:
    """A connection to one process. One thread uses it at a time."""

    def __init__(self, pid: int, path: str) -> None:
        """Connect, without waiting for the greeting.

        Raises:
            OSError: Nobody listens there (any more), or the program takes no more connections.
        """
        self.pid = pid
        self.path = path
        self._socket = socket(AF_UNIX, SOCK_STREAM)
        self._reader = FrameReader()
        self._last_id = 0
        self.greeting: dict[str, Any] | None = None
        """First line of the program; None until it has come."""
        try:
            self._socket.setblocking(False)  # noqa: FBT003 - it takes no keyword
            self._socket.connect(path)
        except OSError:
            self._socket.close()
            raise

    def fileno(self) -> int:
        """Return the descriptor, for `select`."""
        return self._socket.fileno()

    def close(self) -> None:
        """End the connection. May be called repeatedly."""
        self._socket.close()

    def send(
        self, ask: str, arguments: dict[str, Any], payload: bytes = b"", wait_s: float | None = 1.0
    ) -> int:
        """Send a request; return its id.

        Raises:
            ControlError: The program does not take it in time, or has ended.
        """
        self._last_id += 1
        data = encode({"id": self._last_id, "ask": ask, **arguments}, payload)
        try:
            self._socket.settimeout(wait_s)
            self._socket.sendall(data)
        except TimeoutError:
            raise self._silent() from None
        except OSError as error:
            raise self._ended() from error
        finally:
            if self._socket.fileno() >= 0:
                self._socket.setblocking(False)  # noqa: FBT003 - as above
        return self._last_id

    def frames(self) -> Iterator[tuple[dict[str, Any], bytes]]:
        """Yield the frames that have come, without waiting.

        Raises:
            ControlError: The program has ended, or does not speak the protocol.
        """
        try:
            data = self._socket.recv(_CHUNK)
        except BlockingIOError:
            return
        except OSError as error:
            raise self._ended() from error
        if not data:
            raise self._ended()
        self._reader.feed(data)
        while (frame := self._next()) is not None:
            if self.greeting is None:
                self._greet(frame[0])
            else:
                yield frame

    def ask(
        self,
        ask: str,
        arguments: dict[str, Any],
        payload: bytes = b"",
        wait_s: float | None = 1.0,
    ) -> tuple[dict[str, Any], bytes]:
        """Send a request and wait for its answer; return what is in it, and the bytes behind it.

        Raises:
            ControlError: The program refuses it, does not answer in time, or has ended.
        """
        limit = TimeLimit(wait_s)
        number = self.send(ask, arguments, payload, wait_s)
        while True:
            for frame, data in self.frames():
                if frame.get("id") == number:
                    if error := error_in(frame):
                        raise error
                    return frame.get("ok") or {}, data
            if not self.wait(limit):
                raise self._silent()

    def wait(self, limit: TimeLimit) -> bool:
        """Wait until something has come; return False when the time is over."""
        poll = select.poll()
        poll.register(self, select.POLLIN)
        return bool(poll.poll(limit.left_ms))

    def _next(self) -> tuple[dict[str, Any], bytes] | None:
        try:
            return self._reader.next()
        except ControlError as error:
            raise ControlError(f"process {self.pid} sends {error}", "failed") from error

    def wait_for_end(self, limit: TimeLimit) -> bool:
        """Wait until the program closes the connection; return False when the time is over."""
        while self.wait(limit):
            try:
                for _ in self.frames():
                    pass
            except ControlError:
                return True
        return False

    def _greet(self, frame: dict[str, Any]) -> None:
        if frame.get("error") is not None:
            # It has as many clients as it takes.
            raise error_in(frame) or ControlError("no greeting", "failed")
        if frame.get("protocol") != PROTOCOL:
            spoken, version = frame.get("protocol"), frame.get("rosbase")
            text = f"process {self.pid} has rosbase {version} and speaks protocol {spoken}, not 1"
            raise ControlError(text, "failed")
        self.greeting = frame

    def _ended(self) -> ControlError:
        return ControlError(f"process {self.pid} has ended", "failed")

    def _silent(self) -> ControlError:
        return ControlError(f"process {self.pid} does not answer", "timeout")


class Stream:
    """The events of a request that goes on, such as the messages of a topic."""

    def __init__(self, connection: Connection, ask: str, arguments: dict[str, Any]) -> None:
        """Ask on a connection that is this stream's own.

        Raises:
            ControlError: As from `Connection.ask`.
        """
        self.connection = connection
        # Events may come with the answer, so `ask` would lose them.
        self._number = connection.send(ask, arguments)
        self._waiting: list[tuple[dict[str, Any], bytes]] = []
        self.ended: str | None = None
        """Why no more events come; None as long as they do."""
        self.answer = self._wait_for_answer(TimeLimit(1.0))
        """Answer of the program, before the first event."""

    def close(self) -> None:
        """End it. The program notices the end of the connection."""
        self.connection.close()

    def read(self) -> None:
        """Take what has come, without waiting."""
        try:
            for frame, data in self.connection.frames():
                if frame.get("id") == self._number:
                    self._take(frame, data)
        except ControlError as error:
            self.ended = str(error)

    def events(self) -> list[tuple[dict[str, Any], bytes]]:
        """Return the events that have been read, with their bytes, and forget them."""
        events, self._waiting = self._waiting, []
        return events

    def _take(self, frame: dict[str, Any], data: bytes) -> None:
        if "event" in frame:
            self._waiting.append((frame["event"], data))
        elif "end" in frame:
            self.ended = str(frame["end"])
        elif error := error_in(frame):
            self.ended = str(error)

    def _wait_for_answer(self, limit: TimeLimit) -> dict[str, Any]:
        while True:
            answer = None
            for frame, data in self.connection.frames():
                if frame.get("id") != self._number:
                    continue
                if answer is None and (error := error_in(frame)):
                    raise error
                if answer is None and "ok" in frame:
                    answer = frame["ok"] or {}
                else:
                    self._take(frame, data)
            if answer is not None:
                return answer
            if not self.connection.wait(limit):
                raise ControlError(f"process {self.connection.pid} does not answer", "timeout")


def error_in(frame: dict[str, Any]) -> ControlError | None:
    """Return the error that a frame tells of; None if it is none."""
    if "error" not in frame:
        return None
    suggestions = frame.get("suggestions")
    return ControlError(
        str(frame["error"]),
        str(frame.get("kind", "failed")),
        [str(name) for name in suggestions] if isinstance(suggestions, list) else (),
    )
