"""The thread that serves the control socket of this process.

While nobody asks, it sleeps in the kernel. What serves clients is imported when the first one
comes, so that a program pays for a socket and a thread only.
"""

import errno
import selectors
import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from rosbase.clock import SystemClock
from rosbase.control.socket_file import SocketFile, remove_strays
from rosbase.control.unheard import Unheard
from rosbase.logger import RosbaseLogger
from rosbase.runtime.signal_masks import background_thread
from rosbase.runtime.wake_pipe import WakePipe

if TYPE_CHECKING:
    from rosbase.control.clients import Clients

__all__ = ["CLOCK", "ControlServer"]

CLOCK = SystemClock()
"""The clock of the machine: requests time out on it, whatever the time of the program."""

_MOST_ACCEPTS = 16
# When the process has no descriptor left for a connection, or something is wrong.
_PAUSE_NS = 1_000_000_000
_PAUSE_S = 0.1
_END_S = 2.0
_REPORT_S = 10.0
_NS_PER_S = 1_000_000_000
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
            try:
                self.selector = selectors.DefaultSelector()
                """Waits for the sockets of the server and its clients."""
            except BaseException:
                self._pipe.close()
                raise
        except BaseException:
            self._file.remove()
            self._file.listener.close()
            raise
        self._thread = background_thread(self._run, "control")
        self._logger = RosbaseLogger("control")
        self._clients: Clients | None = None
        # What other threads ask for.
        self._calls: deque[Callable[[], object]] = deque()
        self._has_knocked = False
        self._is_ending = False
        self._paused_until_ns: int | None = None
        self._unheard = Unheard(CLOCK.monotonic_ns)
        self.now_ns = CLOCK.monotonic_ns
        """Time on the machine's monotonic clock."""

    def start(self) -> None:
        """Begin to serve.

        Raises:
            RuntimeError: The system has no thread left. Nothing of the server is left either.
        """
        self.selector.register(self._pipe, selectors.EVENT_READ)
        self.selector.register(self._file.listener, selectors.EVENT_READ)
        try:
            self._thread.start()
        except BaseException:
            self._file.remove()
            self._release()
            raise

    def close(self) -> None:
        """End the thread and remove the socket; connections are closed."""
        self._file.remove()
        self._is_ending = True
        self._pipe.wake()
        self._thread.join(_END_S)
        if self._thread.is_alive():
            self._logger.warning("the control socket still answers a request; it is left behind")

    def forget(self) -> None:
        """Close the descriptors in a forked child, whose parent goes on serving."""
        self._file.listener.close()
        if self._clients is not None:
            self._clients.forget()
        self.selector.close()
        self._pipe.abandon()

    # For clients.

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
            if self._clients is not None:
                self.guard(self._clients.end_all, "the end of connections")
        finally:
            self._release()

    def _release(self) -> None:
        if self._clients is not None:
            self._clients.close()
        self.selector.close()
        self._pipe.close()
        self._file.listener.close()

    def _turn(self) -> None:
        for key, mask in self.selector.select(self._patience_s()):
            if key.fileobj is self._pipe:
                self._pipe.drain()
            elif key.fileobj is self._file.listener:
                self._accept()
            elif self._clients is not None:
                self._clients.serve(key.data, mask)
        # Before they are looked at: who comes later knocks again.
        self._has_knocked = False
        while self._calls:
            self.guard(self._calls.popleft(), "a call")
        now_ns = self.now_ns()
        if self._paused_until_ns is not None and now_ns >= self._paused_until_ns:
            self._paused_until_ns = None
            self.selector.register(self._file.listener, selectors.EVENT_READ)
        if self._unheard.due_ns is not None and now_ns >= self._unheard.due_ns:
            self.guard(self._unheard.look, "the look for topics that are not heard")
        if self._clients is not None:
            self._clients.look_after(now_ns)

    def _patience_s(self) -> float | None:
        """Return how long to sleep; None for ever."""
        dues = [
            self._paused_until_ns,
            self._unheard.due_ns,
            self._clients.due_ns if self._clients is not None else None,
        ]
        first_ns = min((due_ns for due_ns in dues if due_ns is not None), default=None)
        return None if first_ns is None else max(0, first_ns - self.now_ns()) / _NS_PER_S

    def _accept(self) -> None:
        if self._clients is None:
            from rosbase.control.clients import Clients

            self._clients = Clients(self)
        for _ in range(_MOST_ACCEPTS):
            try:
                connection, _ = self._file.listener.accept()
            except OSError as error:
                if error.errno in _NO_DESCRIPTORS:
                    # Otherwise the thread would try again and again.
                    self.selector.unregister(self._file.listener)
                    self._paused_until_ns = self.now_ns() + _PAUSE_NS
                return
            self._clients.welcome(connection)
