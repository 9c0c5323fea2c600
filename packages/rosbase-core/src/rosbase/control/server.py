"""The thread that serves the control socket of this process.

While nobody asks, it sleeps in the kernel. Modules that answer are imported at the first request.
"""

import errno
import os
import selectors
import socket
import struct
import threading
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial

from rosbase.clock import SystemClock
from rosbase.control.frames import encode_line
from rosbase.control.programs import running_programs
from rosbase.control.recent_log import recent_log
from rosbase.control.requests import Answerer, error_frame
from rosbase.control.session import Session
from rosbase.control.socket_file import SocketFile, remove_strays
from rosbase.control.streams import Stream
from rosbase.errors import ControlError
from rosbase.logger import RosbaseLogger
from rosbase.runtime.signal_masks import background_thread
from rosbase.runtime.wake_pipe import WakePipe

__all__ = ["CLOCK", "MOST_CLIENTS", "PROTOCOL", "ControlServer"]

CLOCK = SystemClock()
"""The clock of the machine: requests time out on it, whatever the time of the program."""
PROTOCOL = 1
"""Version of the protocol."""
MOST_CLIENTS = 64
"""Maximum number of connections; further ones are closed with an error."""

_MOST_ACCEPTS = 16
# Of requests whose payloads have not come completely, of all connections together.
_MOST_HELD = 268_435_456
# When the process has no descriptor left for a connection.
_PAUSE_NS = 1_000_000_000
_PAUSE_S = 0.1
_END_S = 2.0
_REPORT_S = 10.0
_NS_PER_S = 1_000_000_000
_ENDING = "the program ends"
_NO_DESCRIPTORS = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)


class ControlServer:
    """A listening socket and its thread."""

    def __init__(self) -> None:
        """Open the socket.

        Raises:
            ControlError: The folder of the sockets cannot be used.
            OSError: There are no descriptors left, or the socket cannot be made.
        """
        self._file = SocketFile()
        try:
            self._pipe = WakePipe()
            self._selector = selectors.DefaultSelector()
        except BaseException:
            self._file.remove()
            self._file.listener.close()
            raise
        self._thread = background_thread(self._run, "control")
        self._logger = RosbaseLogger("control")
        self._sessions: dict[socket.socket, Session] = {}
        self._again: dict[Session, None] = {}
        self._answers: Mapping[str, Answerer] | None = None
        # What other threads ask for.
        self._calls: deque[Callable[[], object]] = deque()
        self._has_knocked = False
        self._is_ending = False
        self._paused_until_ns: int | None = None
        self._dropped = 0
        self.now_ns = CLOCK.monotonic_ns

    def start(self) -> None:
        """Begin to serve.

        Raises:
            RuntimeError: The system has no thread left. Nothing of the server is left either.
        """
        self._selector.register(self._pipe, selectors.EVENT_READ)
        self._selector.register(self._file.listener, selectors.EVENT_READ)
        try:
            self._thread.start()
        except BaseException:
            self._file.remove()
            self._release()
            raise
        recent_log.start()

    def close(self) -> None:
        """End the thread and remove the socket; connections are closed."""
        self._file.remove()
        recent_log.stop()
        self._is_ending = True
        self._pipe.wake()
        self._thread.join(_END_S)
        if self._thread.is_alive():
            self._logger.warning("the control socket still answers a request; it is left behind")

    def forget(self) -> None:
        """Close the descriptors in a forked child, whose parent goes on serving."""
        recent_log.stop()
        self._file.listener.close()
        for session in self._sessions.values():
            session.forget()
        self._selector.close()
        self._pipe.abandon()

    # For sessions and streams.

    @property
    def is_own_thread(self) -> bool:
        """Whether the caller is on the thread of the socket."""
        return threading.get_ident() == self._thread.ident

    def call(self, function: Callable[[], object]) -> None:
        """Call the function soon on the thread of the socket. Call it from any thread."""
        self._calls.append(function)
        if not self._has_knocked:
            self._has_knocked = True
            self._pipe.wake()

    def pump_soon(self, session: Session) -> Callable[[Stream], object]:
        """Return the function by which streams of a session wake the thread."""
        call, pump_again = self.call, partial(self.pump_again, session)
        return lambda stream: call(pump_again)

    def pump_again(self, session: Session) -> None:
        """Have the streams of a session looked at in this turn or the next."""
        self._again[session] = None

    def find_answerer(self, ask: str) -> Answerer:
        """Return the function that answers a request.

        Raises:
            ControlError: There is none.
        """
        if self._answers is None:
            from rosbase.control.answers import all_answers

            self._answers = all_answers()
        known = {**self._answers}
        for program in running_programs():
            # Those of the programs after ours, which are the same in every process.
            known = {**program.answers(), **known}
        if ask in known:
            return known[ask]
        from difflib import get_close_matches

        near = get_close_matches(ask, known)
        raise ControlError(f"there is no request {ask[:100]!r}", "unknown", near)

    def counts(self) -> dict[str, int]:
        """Return the number of clients, and of events that they have lost."""
        lost = sum(session.lost for session in self._sessions.values())
        return {"clients": len(self._sessions), "dropped": self._dropped + lost}

    def guard(self, function: Callable[[], object], what: str) -> bool:
        """Call a function; an exception is logged. Return whether there was none."""
        try:
            function()
        except Exception as error:
            self.report(what, error)
            return False
        return True

    def report(self, what: str, error: Exception) -> None:
        """Log an exception, not often."""
        if self._logger.due(what, _REPORT_S):
            self._logger.error(f"{what} failed: {error!r}", exc_info=error)

    # The thread.

    def _run(self) -> None:
        try:
            self.guard(partial(remove_strays, self._file.folder), "the removal of stale sockets")
            while not self._is_ending:
                if not self.guard(self._turn, "the control socket"):
                    # Whatever is wrong, it must not take the processor.
                    CLOCK.sleep(_PAUSE_S)
            for session in list(self._sessions.values()):
                self.guard(partial(session.end_all, _ENDING), "the end of a connection")
        finally:
            self._release()

    def _release(self) -> None:
        for session in list(self._sessions.values()):
            self._close(session)
        self._selector.close()
        self._pipe.close()
        self._file.listener.close()

    def _turn(self) -> None:
        for key, mask in self._selector.select(self._patience_s()):
            if key.fileobj is self._pipe:
                self._pipe.drain()
            elif key.fileobj is self._file.listener:
                self._accept()
            elif key.data in self._sessions.values():
                self._serve(key.data, mask)
        # Before they are looked at: who comes later knocks again.
        self._has_knocked = False
        while self._calls:
            self.guard(self._calls.popleft(), "a call")
        again, self._again = self._again, {}
        now_ns = self.now_ns()
        if self._paused_until_ns is not None and now_ns >= self._paused_until_ns:
            self._paused_until_ns = None
            self._selector.register(self._file.listener, selectors.EVENT_READ)
        for session in list(self._sessions.values()):
            self._look_after(session, now_ns, is_due=session in again)

    def _look_after(self, session: Session, now_ns: int, *, is_due: bool) -> None:
        try:
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
                session.watch(self._selector)
        except Exception as error:
            self.report("a connection", error)
            self._close(session)

    def _patience_s(self) -> float | None:
        """Return how long to sleep; None for ever."""
        sessions = self._sessions.values()
        if self._again or any(session.has_frames for session in sessions):
            return 0.0
        dues = [self._paused_until_ns, *(session.due_ns for session in sessions)]
        first_ns = min((due_ns for due_ns in dues if due_ns is not None), default=None)
        if first_ns is None:
            return None
        return max(0, first_ns - self.now_ns()) / _NS_PER_S

    def _serve(self, session: Session, mask: int) -> None:
        try:
            if mask & selectors.EVENT_READ:
                session.read()
                if sum(one.held for one in self._sessions.values()) > _MOST_HELD:
                    session.refuse(ControlError("too many bytes wait in this process", "refused"))
            if mask & selectors.EVENT_WRITE:
                session.flush()
                self._again[session] = None
        except Exception as error:
            self.report("a connection", error)
            self._close(session)

    def _accept(self) -> None:
        for _ in range(_MOST_ACCEPTS):
            try:
                connection, _ = self._file.listener.accept()
            except OSError as error:
                if error.errno in _NO_DESCRIPTORS:
                    # Otherwise the thread would try again and again.
                    self._selector.unregister(self._file.listener)
                    self._paused_until_ns = self.now_ns() + _PAUSE_NS
                return
            self._welcome(connection)

    def _welcome(self, connection: socket.socket) -> None:
        connection.settimeout(0)
        session = Session(self, connection)
        if not may_connect(connection):
            session.greet(_refusal("this socket belongs to another user"))
            session.close()
        elif len(self._sessions) >= MOST_CLIENTS:
            session.greet(_refusal(f"{MOST_CLIENTS} clients are connected"))
            session.close()
        else:
            self._sessions[connection] = session
            session.watch(self._selector)
            session.greet(self._hello())

    def _close(self, session: Session) -> None:
        session.unwatch(self._selector)
        session.close()
        self._dropped += session.dropped
        self._again.pop(session, None)
        self._sessions = {key: one for key, one in self._sessions.items() if one is not session}

    def _hello(self) -> bytes:
        # Python's reader of versions takes ten milliseconds to import.
        from rosbase.control.version import rosbase_version

        hello = {"rosbase": rosbase_version(), "protocol": PROTOCOL, "pid": os.getpid()}
        return encode_line(hello)


def may_connect(connection: socket.socket) -> bool:
    """Return whether the other side is this user, or root."""
    if not hasattr(socket, "SO_PEERCRED"):
        # Only Linux has it. Elsewhere the modes of folder and file decide.
        return True
    size = struct.calcsize("3i")
    found = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size)
    _, uid, _ = struct.unpack("3i", found)
    return uid in (0, os.geteuid())


def _refusal(text: str) -> bytes:
    return encode_line({"id": None, **error_frame(ControlError(text, "refused"))})
