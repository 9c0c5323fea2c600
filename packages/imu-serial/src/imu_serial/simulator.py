"""A stand-in for a serial device: the far end of a pseudo-terminal pair."""

import os
import select
import threading
import tty
from collections.abc import Mapping

from rosbase import ParameterValue, TransportError

__all__ = ["PtyDevice"]

_POLL_MS = 100


class PtyDevice:
    """A device on a line that the kernel makes: the reader opens it like any other port."""

    def __init__(self) -> None:
        """Makes the line and gives it a name."""
        self._fd, far_end = os.openpty()
        # Held open, so that the line outlives readers that come and go.
        self._far_end = far_end
        tty.setraw(far_end)
        os.set_blocking(self._fd, False)
        self._path = os.ttyname(far_end)
        self._lock = threading.Lock()
        self._is_closed = False

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """What the transport `serial` must be given to reach this device."""
        return {"device_path": self._path}

    def send(self, payload: bytes) -> None:
        """Sends one line, CR LF at its end. Waits while the line is full.

        Raises:
            TransportError: The line has been closed.
        """
        self.write(payload + b"\r\n")

    def write(self, data: bytes) -> None:
        """Sends bytes as they are. Waits while the line is full.

        Raises:
            TransportError: The line has been closed.
        """
        while data:
            data = data[self._write_some(data) :]

    def close(self) -> None:
        """Pulls the plug."""
        with self._lock:
            if not self._is_closed:
                self._is_closed = True
                os.close(self._far_end)
                os.close(self._fd)

    def _write_some(self, data: bytes) -> int:
        with self._lock:
            if self._is_closed:
                raise TransportError(f"{self._path} has been closed")
            try:
                return os.write(self._fd, data)
            except BlockingIOError:
                fd = self._fd
        # Not under the lock, so that `close` need not wait; it is noticed the next time round.
        ready = select.poll()
        ready.register(fd, select.POLLOUT)
        ready.poll(_POLL_MS)
        return 0
