"""Device that sends as fast as it can."""

import threading
from collections.abc import Callable
from itertools import cycle

from rosbase.clock import SystemClock
from rosbase.errors import TransportError

__all__ = ["Flood"]

_LOOK_S = 0.01
_STUCK_LOOKS = 30


class Flood:
    """Thread that sends until it is ended, or the link is closed."""

    def __init__(self, send: Callable[[bytes], object], payloads: list[bytes]) -> None:
        """Start sending."""
        self.sent_bytes = 0
        """Number of bytes that the link has taken so far."""
        self.failure: Exception | None = None
        """Error in the author's code that prevented sending, if any."""
        self._send = send
        self._payloads = payloads
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="rosbase-kit-flood", daemon=True)
        self._thread.start()

    def wait_for(self, size_bytes: int, limit_s: float) -> None:
        """Wait until that much is sent, the link takes no more, or the time is up."""
        clock = SystemClock()
        deadline_ns = clock.monotonic_ns() + int(limit_s * 1e9)
        idle_looks, seen = 0, -1
        while self.sent_bytes < size_bytes and idle_looks < _STUCK_LOOKS:
            if clock.monotonic_ns() > deadline_ns:
                return
            idle_looks = idle_looks + 1 if self.sent_bytes == seen else 0
            seen = self.sent_bytes
            clock.sleep(_LOOK_S)

    def end(self) -> None:
        """Stop sending when the link has taken the current payload."""
        self._ends.set()

    def _run(self) -> None:
        for payload in cycle(self._payloads):
            if self._ends.is_set():
                return
            try:
                # A copy, because on a link in this process the same object costs nothing.
                self._send(bytes(bytearray(payload)))
            except TransportError:
                return
            except Exception as error:
                # Boundary to the author's code, on a thread whose errors nobody sees.
                self.failure = error
                return
            self.sent_bytes += len(payload)
