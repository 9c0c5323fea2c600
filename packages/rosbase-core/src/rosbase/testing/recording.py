"""A subscriber that keeps what it is given."""

import threading
from typing import NamedTuple

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.transport import OnFrame

__all__ = ["Received", "RecordingSubscriber"]


class Received(NamedTuple):
    """A frame, and how it came."""

    frame: bytes
    stamp_ns: int
    """As the transport has stamped it."""
    arrived_ns: int
    """When it was handed over, on the subscriber's clock."""
    thread: threading.Thread
    """The one that handed it over."""


class RecordingSubscriber:
    """An `on_frame` for tests: keeps every frame with its stamp, and waits for them with a limit.

    It may be called from any thread.
    """

    def __init__(self, clock: Clock | None = None, then: OnFrame | None = None) -> None:
        """Has received nothing yet.

        Args:
            clock: Dates the arrivals; the system's by default.
            then: Called after a frame has been kept, with the same arguments, for whatever else
                the subscriber is to do, such as raise. What it returns is the answer.
        """
        self._clock = clock or SystemClock()
        self._then = then
        self._received: list[Received] = []
        self._has_changed = threading.Condition()

    def __call__(self, frame: bytes, stamp_ns: int) -> bool | None:
        """Keep a frame; answer as `then` does, or None."""
        received = Received(frame, stamp_ns, self._clock.now_ns(), threading.current_thread())
        with self._has_changed:
            self._received.append(received)
            self._has_changed.notify_all()
        return None if self._then is None else self._then(frame, stamp_ns)

    @property
    def received(self) -> list[Received]:
        """Everything so far, in the order of its arrival."""
        with self._has_changed:
            return list(self._received)

    @property
    def frames(self) -> list[bytes]:
        """The frames so far, in the order of their arrival."""
        return [received.frame for received in self.received]

    def wait_for(self, count: int, timeout_s: float = 5.0) -> bool:
        """Waits for so many frames in all; tells whether they came in time."""
        with self._has_changed:
            return self._has_changed.wait_for(lambda: len(self._received) >= count, timeout_s)

    def wait_for_frame(self, frame: bytes, timeout_s: float = 5.0) -> bool:
        """Waits until that very frame has come; tells whether it came in time."""
        with self._has_changed:
            return self._has_changed.wait_for(
                lambda: any(received.frame == frame for received in reversed(self._received)),
                timeout_s,
            )

    def clear(self) -> None:
        """Forgets everything so far."""
        with self._has_changed:
            self._received.clear()
