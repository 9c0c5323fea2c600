"""The clients of the control socket: who may come, and whose turn it is.

Everything here happens on the thread of the socket.
"""

import os
import selectors
import socket
import struct
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from rosbase.control.answers import all_answers
from rosbase.control.frames import encode_line
from rosbase.control.programs import running_programs
from rosbase.control.requests import Answerer, error_frame
from rosbase.control.session import Session
from rosbase.control.streams import Stream
from rosbase.control.version import rosbase_version
from rosbase.errors import ControlError

if TYPE_CHECKING:
    from rosbase.control.server import ControlServer

__all__ = ["MOST_CLIENTS", "PROTOCOL", "Clients", "may_connect"]

PROTOCOL = 1
"""Version of the protocol."""
MOST_CLIENTS = 64
"""Maximum number of connections; beyond it, idle ones make room, or further ones are refused."""

# So long a client may take from one request to the next, whoever else comes.
_REST_NS = 2_000_000_000

# Of requests whose payloads have not come completely, of all connections together.
_MOST_HELD = 268_435_456
_ENDING = "the program ends"


class Clients:
    """The connections of a server."""

    def __init__(self, server: "ControlServer") -> None:
        self._server = server
        self._sessions: dict[Session, None] = {}
        # Those whose streams have a turn.
        self._again: dict[Session, None] = {}
        self._answers: Mapping[str, Answerer] | None = None
        self._dropped = 0

    # For the server.

    @property
    def due_ns(self) -> int | None:
        """When the clients have something to do, on the monotonic clock; None if never."""
        if self._again or any(session.has_frames for session in self._sessions):
            return 0
        dues = [session.due_ns for session in self._sessions]
        return min((due_ns for due_ns in dues if due_ns is not None), default=None)

    def welcome(self, connection: socket.socket) -> None:
        """Take a new connection, or refuse it."""
        connection.settimeout(0)
        session = Session(self, self._server, connection)
        if not may_connect(connection):
            refusal = "this socket belongs to another user"
        elif len(self._sessions) >= MOST_CLIENTS and not self._make_room():
            refusal = f"{MOST_CLIENTS} clients are connected to process {os.getpid()}"
        else:
            self._sessions[session] = None
            hello = {"rosbase": rosbase_version(), "protocol": PROTOCOL, "pid": os.getpid()}
            session.greet(encode_line(hello))
            session.watch(self._server.selector)
            return
        fault = ControlError(refusal, "refused")
        session.greet(encode_line({"id": None, **error_frame(fault)}))
        session.close()

    def serve(self, session: Session, mask: int) -> None:
        """Read from, and write to, a connection that is ready for it."""
        if session not in self._sessions:
            # Closed by an event before this one.
            return
        try:
            if mask & selectors.EVENT_READ:
                session.read()
                if sum(one.held for one in self._sessions) > _MOST_HELD:
                    session.refuse(ControlError("too many bytes wait in this process", "refused"))
            if mask & selectors.EVENT_WRITE:
                session.flush()
                self._again[session] = None
        except Exception as error:
            self._server.report("a connection", error)
            self._close(session)

    def look_after(self, now_ns: int) -> None:
        """Do what is due, and send what can be sent."""
        again, self._again = self._again, {}
        for session in list(self._sessions):
            try:
                self._look_after(session, now_ns, is_due=session in again)
            except Exception as error:
                self._server.report("a connection", error)
                self._close(session)

    def end_all(self) -> None:
        """Tell the clients that the process ends."""
        for session in self._sessions:
            self._server.guard(partial(session.end_all, _ENDING), "the end of a connection")

    def close(self) -> None:
        """Close all connections."""
        for session in list(self._sessions):
            self._close(session)

    def forget(self) -> None:
        """Close the descriptors in a forked child."""
        for session in self._sessions:
            session.forget()

    # For sessions.

    def pump_soon(self, session: Session) -> Callable[[Stream], object]:
        """Return the function by which streams of a session wake the thread, on any thread."""
        call, pump_again = self._server.call, partial(self.pump_again, session)
        return lambda _: call(pump_again)

    def pump_again(self, session: Session) -> None:
        """Have the streams of a session looked at in this turn or the next."""
        self._again[session] = None

    def find_answerer(self, ask: str) -> Answerer:
        """Return the function that answers a request.

        Raises:
            ControlError: There is none.
        """
        if self._answers is None:
            self._answers = all_answers()
        known = self._answers
        for program in running_programs():
            # The other programs' values, which are the same in every process.
            known = {**program.answers(), **known}
        if ask in known:
            return known[ask]
        from difflib import get_close_matches

        near = get_close_matches(ask, known)
        raise ControlError(f"there is no request {ask[:100]!r}", "unknown", near)

    def report(self, what: str, error: Exception) -> None:
        """Log an exception of an answer, but not while a program ends: what it asks may be gone."""
        if not any(program.phase == "stopping" for program in running_programs()):
            self._server.report(what, error)

    def counts(self) -> dict[str, int]:
        """Return the number of clients, and of events that clients have lost."""
        lost = sum(session.lost for session in self._sessions)
        return {"clients": len(self._sessions), "dropped": self._dropped + lost}

    def _make_room(self) -> bool:
        """Close the connection that has been idle for longest; return False if none is idle.

        Otherwise a client that forgets its connections would keep others from the program, even
        from stopping it.
        """
        idle = [session for session in self._sessions if session.is_idle]
        longest = min(idle, key=lambda session: session.heard_ns, default=None)
        if longest is None or self._server.now_ns() - longest.heard_ns < _REST_NS:
            return False
        text = f"{MOST_CLIENTS} clients are connected to process {os.getpid()}, and this one rests"
        longest.refuse(ControlError(text, "refused"))
        longest.flush()
        self._close(longest)
        return True

    def _look_after(self, session: Session, now_ns: int, *, is_due: bool) -> None:
        due_ns = session.due_ns
        if due_ns is not None and due_ns <= now_ns:
            session.time_out(now_ns)
            is_due = True
        if session.has_frames:
            session.handle_frames()
        has_more = is_due and session.pump()
        session.flush()
        if has_more and session.has_room:
            self._again[session] = None
        if session.is_over:
            self._close(session)
        else:
            session.watch(self._server.selector)

    def _close(self, session: Session) -> None:
        session.unwatch(self._server.selector)
        session.close()
        self._dropped += session.dropped
        self._again.pop(session, None)
        self._sessions.pop(session, None)


def may_connect(connection: socket.socket) -> bool:
    """Return whether the other side is this user, or root."""
    if not hasattr(socket, "SO_PEERCRED"):
        # Only Linux has it. Elsewhere the modes of folder and file decide.
        return True
    size = struct.calcsize("3i")
    found = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size)
    _, uid, _ = struct.unpack("3i", found)
    return uid in (0, os.geteuid())
