"""Subscriber that records frames."""

import threading
from typing import NamedTuple

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.transport import OnFrame

__all__ = ["Received", "RecordingSubscriber"]


class Received(NamedTuple):
    """Frame with its stamp, arrival time and thread."""

    frame: bytes
    stamp_ns: int
    """Stamp from the transport."""
    arrived_ns: int
    """Time of the delivery, on the subscriber's clock."""
    thread: threading.Thread
    """Thread that delivered it."""


class RecordingSubscriber:
    """`on_frame` for tests: records every frame with its stamp, and waits with a timeout.

    Any thread may call it.
    """

    def __init__(self, clock: Clock | None = None, then: OnFrame | None = None) -> None:
        """Start without frames.

        Args:
            clock: Dates the arrivals; the system's clock by default.
            then: Called after a frame has been recorded, with the same arguments, for further
                actions of the subscriber, such as raising. Its return value is the answer.
        """
        self._clock = clock or SystemClock()
        self._then = then
        self._received: list[Received] = []
        self._has_changed = threading.Condition()

    def __call__(self, frame: bytes, stamp_ns: int) -> bool | None:
        """Record a frame; return the answer of `then`, or None."""
        received = Received(frame, stamp_ns, self._clock.now_ns(), threading.current_thread())
        with self._has_changed:
            self._received.append(received)
            self._has_changed.notify_all()
        return None if self._then is None else self._then(frame, stamp_ns)

    @property
    def received(self) -> list[Received]:
        """Arrivals so far, in order."""
        with self._has_changed:
            return list(self._received)

    @property
    def frames(self) -> list[bytes]:
        """Frames so far, in the order of their arrival."""
        return [received.frame for received in self.received]

    def wait_for(self, count: int, timeout_s: float = 5.0) -> bool:
        """Wait for a total number of frames; return whether they came in time."""
        with self._has_changed:
            return self._has_changed.wait_for(lambda: len(self._received) >= count, timeout_s)

    def wait_for_frame(self, frame: bytes, timeout_s: float = 5.0) -> bool:
        """Wait for the given frame; return whether it came in time."""
        with self._has_changed:
            return self._has_changed.wait_for(
                lambda: any(received.frame == frame for received in reversed(self._received)),
                timeout_s,
            )

    def clear(self) -> None:
        """Forget all frames so far."""
        with self._has_changed:
            self._received.clear()
