"""One connection of a client: bytes in, answers and events out, with bounded memory."""

import select
import selectors
import socket
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from rosbase.control.frames import MOST_PAYLOAD, MOST_REQUEST, FrameReader, encode_line
from rosbase.control.outbox import Outbox
from rosbase.control.requests import Later, Request, error_frame
from rosbase.control.streams import Stream
from rosbase.errors import ControlError

if TYPE_CHECKING:
    from rosbase.control.clients import Clients
    from rosbase.control.server import ControlServer

__all__ = ["Session"]

_CHUNK = 65_536
# In one turn of the thread, so that no client keeps it, or Python's lock, from others for long.
_MOST_REQUESTS = 16
_MOST_EVENTS = 64
_MOST_OPEN = 64
# While more bytes wait for the client, streams give no events.
_ROOM = 262_144
# While more bytes wait, no requests are read.
_MOST_WAITING = 1_048_576
# A client that has so much waiting is not coming back for it.
_MOST_OUT = 268_435_456
_MOST_ID = 2**53
# How often a client is looked for that asks nothing more, and cannot be heard to leave.
_LOOK_NS = 1_000_000_000
# For a client whose garbage is thrown away after the connection was given up.
_MOST_DISCARDED = 16


class Session:
    """A connection. Unless it says so, everything here happens on the thread of the socket."""

    def __init__(
        self, clients: "Clients", server: "ControlServer", connection: socket.socket
    ) -> None:
        self._clients = clients
        self._server = server
        self._connection = connection
        self._reader = FrameReader(MOST_REQUEST)
        # Bytes that were fed may have more frames than one turn takes.
        self._has_frames = False
        self._out = Outbox()
        self._open: dict[int, Request] = {}
        self._streams: dict[int, Stream] = {}
        self._closers: list[Callable[[], object]] = []
        self._is_closed = False
        self._is_ending = False
        # A client may say that it asks nothing more, and still read.
        self._has_read_all = False
        self._look_ns = 0
        self._watched = 0
        self.kept: dict[str, Any] = {}
        """Whatever an answerer keeps for later requests of this connection."""
        self.dropped = 0
        """Number of events that streams of this connection lost, of those that have ended."""
        self.heard_ns = server.now_ns()
        """When the client has sent something, or has come."""

    # For answerers.

    def on_close(self, function: Callable[[], object]) -> None:
        """Call the function when the connection ends, on the thread of the socket."""
        self._closers.append(function)

    def now_ns(self) -> int:
        """Return the time on the machine's monotonic clock. Call it from any thread."""
        return self._server.now_ns()

    def call(self, function: Callable[[], object]) -> None:
        """Call the function soon on the thread of the socket. Call it from any thread."""
        self._server.call(function)

    def counts(self) -> dict[str, int]:
        """Return the number of clients, and of events that they have lost."""
        return self._clients.counts()

    def answered(self, request: Request, frame: dict[str, Any], data: bytes) -> None:
        """Send the answer of a request. Call it from any thread."""
        if self._server.is_own_thread:
            self._finish(request, frame, data)
        else:
            self._server.call(lambda: self._finish(request, frame, data))

    @property
    def is_closed(self) -> bool:
        """Whether the connection has ended."""
        return self._is_closed

    # For the server.

    @property
    def lost(self) -> int:
        """Number of events that this client has lost."""
        return self.dropped + sum(stream.dropped for stream in self._streams.values())

    @property
    def held(self) -> int:
        """Number of bytes that wait for the rest of their frame."""
        return self._reader.held

    @property
    def is_idle(self) -> bool:
        """Whether the client waits for nothing, and has nothing here that it could miss."""
        is_busy = self._open or self._streams or self._out.size or self._has_frames
        return not (is_busy or self._closers or self.held)

    @property
    def wants_to_read(self) -> bool:
        """Whether requests are read: not while the client leaves answers unread."""
        return self._may_handle and not self._has_read_all

    @property
    def _may_handle(self) -> bool:
        return self._out.size < _MOST_WAITING and not self._is_ending

    @property
    def has_room(self) -> bool:
        """Whether streams may send: the client reads."""
        return self._out.size < _ROOM

    @property
    def is_over(self) -> bool:
        """Whether the connection is to be closed."""
        has_answered = self._has_read_all and not (self._open or self._streams or self._has_frames)
        return (self._is_ending or has_answered) and not self._out.size

    @property
    def due_ns(self) -> int | None:
        """The first instant at which a request times out or a stream has an event."""
        dues = [request.deadline_ns for request in self._open.values()]
        if self.has_room:
            dues += [stream.due_ns for stream in self._streams.values()]
        if self._has_read_all:
            dues.append(self._look_ns)
        return min((due_ns for due_ns in dues if due_ns is not None), default=None)

    def watch(self, selector: selectors.BaseSelector) -> None:
        """Have the selector tell of what the session needs next."""
        reads = selectors.EVENT_READ if self.wants_to_read else 0
        self._watch(selector, reads | (selectors.EVENT_WRITE if self._out.size else 0))

    def unwatch(self, selector: selectors.BaseSelector) -> None:
        """Have the selector tell of nothing any more."""
        self._watch(selector, 0)

    def _watch(self, selector: selectors.BaseSelector, events: int) -> None:
        if events == self._watched:
            return
        if not events:
            selector.unregister(self._connection)
        elif self._watched:
            selector.modify(self._connection, events, self)
        else:
            selector.register(self._connection, events, self)
        self._watched = events

    def greet(self, hello: bytes) -> None:
        """Send the first line."""
        self._put(hello)
        self.flush()

    def read(self) -> None:
        """Take what the client has sent, and begin to answer it."""
        try:
            data = self._connection.recv(_CHUNK)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        if not data:
            self._has_read_all = True
            if self._is_abandoned():
                self._give_up()
            return
        self.heard_ns = self.now_ns()
        self._reader.feed(data)
        self.handle_frames()

    def handle_frames(self) -> None:
        """Handle some of the frames that have come; the rest has its turn later."""
        for _ in range(_MOST_REQUESTS):
            if not self._may_handle:
                break
            try:
                frame = self._reader.next()
            except ControlError as error:
                self.refuse(error)
                return
            if frame is None:
                self._has_frames = False
                return
            self._handle(*frame)
        self._has_frames = True

    @property
    def has_frames(self) -> bool:
        """Whether frames wait that can be handled now."""
        return self._has_frames and self._may_handle

    def refuse(self, error: ControlError) -> None:
        """Send an error that belongs to no request, and end the connection."""
        self._send({"id": None, **error_frame(error)})
        self._is_ending = True
        try:
            # Otherwise the system takes the error away from the client with the connection.
            for _ in range(_MOST_DISCARDED):
                if not self._connection.recv(_CHUNK):
                    break
        except OSError:
            pass

    def pump(self) -> bool:
        """Send what streams have, as far as the client reads; return whether there may be more."""
        has_more = False
        for number, stream in list(self._streams.items()):
            before = self._out.size
            if self._pump(number, stream):
                has_more = True
                if self._out.size > before:
                    # It has had its turn; the next one begins with the others.
                    self._streams[number] = self._streams.pop(number)
        return has_more

    def time_out(self, now_ns: int) -> None:
        """Fail the requests whose time is up, and look whether the client is still there."""
        if self._has_read_all and now_ns >= self._look_ns:
            self._look_ns = now_ns + _LOOK_NS
            if self._is_abandoned():
                self._give_up()
        for request in list(self._open.values()):
            if request.deadline_ns is not None and request.deadline_ns <= now_ns:
                request.time_out()

    def flush(self) -> None:
        """Send as much as the client takes now."""
        try:
            self._out.send(self._connection)
        except OSError:
            self._give_up()

    def end_all(self, reason: str) -> None:
        """Tell the client that the process ends, as far as it reads."""
        for request in list(self._open.values()):
            request.fail(ControlError(reason, "refused"))
        for number in list(self._streams):
            self._end_stream(number, reason)
        self.flush()

    def close(self) -> None:
        """Close the connection, and release what it holds. Idempotent."""
        if self._is_closed:
            return
        self._is_closed = self._is_ending = True
        for number in list(self._streams):
            self._close_stream(number)
        self._open.clear()
        self._out.clear()
        for closer in self._closers:
            self._server.guard(closer, "the end of a connection")
        self._connection.close()

    def forget(self) -> None:
        """Close the descriptor in a forked child; the connection is the parent's."""
        self._connection.close()

    def _is_abandoned(self) -> bool:
        """Return whether the client has closed the connection, not only its own direction."""
        poll = select.poll()
        poll.register(self._connection, 0)
        return bool(poll.poll(0))

    def _give_up(self) -> None:
        """End the connection; nobody is there to read what still waits."""
        self._out.clear()
        self._is_ending = True

    # How a frame is handled.

    def _handle(self, frame: dict[str, Any], data: bytes) -> None:
        number, ask = frame.get("id"), frame.get("ask")
        if type(number) is not int or abs(number) > _MOST_ID or not isinstance(ask, str):
            fault = ControlError("a request has a whole number as id, and a text as ask", "invalid")
            self._send({"id": None, **error_frame(fault)})
            return
        request = Request(self, number, ask, frame, data)
        if number in self._open or number in self._streams:
            self._reject(number, ControlError(f"request {number} is open already", "invalid"))
        elif ask == "cancel":
            self._cancel(request)
        elif len(self._open) + len(self._streams) >= _MOST_OPEN:
            self._reject(number, ControlError(f"{_MOST_OPEN} requests are open", "refused"))
        else:
            self._open[number] = request
            self._answer(request)

    def _answer(self, request: Request) -> None:
        try:
            reply = self._clients.find_answerer(request.ask)(self, request)
        except ControlError as error:
            request.fail(error)
            return
        except Exception as error:
            self._clients.report(request.ask, error)
            request.fail(ControlError(f"{type(error).__name__}: {error}"))
            return
        if isinstance(reply, Stream):
            self._begin_stream(request, reply)
        elif isinstance(reply, tuple):
            request.answer(*reply)
        elif not isinstance(reply, Later):
            request.answer(reply)
        elif request.deadline_ns is None:
            request.wait()

    def _finish(self, request: Request, frame: dict[str, Any], data: bytes) -> None:
        if self._open.pop(request.id, None) is not None and not self._is_closed:
            self._send(frame, data)

    def _reject(self, number: int, error: ControlError) -> None:
        self._send({"id": number, **error_frame(error)})

    def _cancel(self, request: Request) -> None:
        try:
            number = request.whole("of", least=-_MOST_ID)
        except ControlError as error:
            self._reject(request.id, error)
            return
        if number in self._streams:
            self._send({"id": request.id, "ok": {}})
            self._end_stream(number, "cancelled")
        else:
            self._reject(request.id, ControlError(f"no stream {number!r} is open", "unknown"))

    # Streams.

    def _begin_stream(self, request: Request, stream: Stream) -> None:
        self._streams[request.id] = stream
        stream._wake = self._clients.pump_soon(self)
        request.answer(stream.ok, stream.data)
        if self._pump(request.id, stream):
            self._clients.pump_again(self)

    def _pump(self, number: int, stream: Stream) -> bool:
        # What is appended from now on wakes again; but not while nobody reads.
        stream._is_woken = not self.has_room
        for _ in range(_MOST_EVENTS):
            if not self.has_room:
                stream._is_woken = True
                return True
            try:
                event = stream.take()
            except Exception as error:
                self._clients.report("a stream", error)
                self._end_stream(number, "failed")
                return False
            if event is None:
                if stream.ended:
                    self._end_stream(number, stream.ended)
                return False
            self._send_event(number, *event)
        return True

    def _end_stream(self, number: int, reason: str) -> None:
        if self._close_stream(number):
            self._send({"id": number, "end": reason})

    def _close_stream(self, number: int) -> bool:
        stream = self._streams.pop(number, None)
        if stream is None:
            return False
        self._server.guard(stream.close, "the end of a stream")
        self.dropped += stream.dropped
        return True

    # Bytes out.

    def _send(self, frame: dict[str, Any], data: bytes = b"") -> None:
        try:
            line = encode_line(frame, len(data))
        except ControlError as error:
            fault = ControlError(f"the answer cannot be sent: {error}")
            line, data = encode_line({"id": frame.get("id"), **error_frame(fault)}), b""
        self._put(line, data)

    def _send_event(self, number: int, event: dict[str, Any] | str, data: bytes) -> None:
        if isinstance(event, str) and len(data) <= MOST_PAYLOAD:
            size = f',"bytes":{len(data)}' if data else ""
            line = f'{{"id":{number},"event":{event}{size}}}\n'.encode("ascii")
            self._put(line, data)
        else:
            self._send({"id": number, "event": event}, data)

    def _put(self, line: bytes, data: bytes = b"") -> None:
        self._out.put_frame(line, data)
        if self._out.size > _MOST_OUT:
            self._give_up()
