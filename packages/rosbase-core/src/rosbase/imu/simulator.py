"""A simulated IMU: sends the measurements of an ideal device on a known motion, at a fixed rate."""

import threading
from collections.abc import Callable, Iterable
from typing import TypeAlias

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.transport import PluggableDevice, SimulatedDevice
from rosbase.errors import TransportError
from rosbase.imu.motion import motion_at
from rosbase.messages import Time
from rosbase.runtime.signal_masks import background_thread

__all__ = ["Fault", "ImuSimulator", "payload_at"]

Fault: TypeAlias = Callable[[int, bytes], Iterable[bytes]]
"""Function that returns the faulty payload for a sample, by its number and its payload."""

_NS_PER_S = 1_000_000_000
_PATIENCE_S = 1.0


def payload_at(t: float, stamp: Time, frame_id: str = "imu_link") -> bytes:
    """Return the sample at `t` seconds of the motion, as one line of JSON in the preset `ros`."""
    sample = motion_at(t)
    q, w, a = sample.orientation, sample.angular_velocity, sample.linear_acceleration
    return (
        f'{{"header":{{"stamp":{{"sec":{stamp.sec},"nanosec":{stamp.nanosec}}},'
        f'"frame_id":"{frame_id}"}},'
        f'"orientation":{{"x":{q.x:.8f},"y":{q.y:.8f},"z":{q.z:.8f},"w":{q.w:.8f}}},'
        f'"angular_velocity":{{"x":{w.x:.6f},"y":{w.y:.6f},"z":{w.z:.6f}}},'
        f'"linear_acceleration":{{"x":{a.x:.6f},"y":{a.y:.6f},"z":{a.z:.6f}}}}}'
    ).encode()


class ImuSimulator:
    """Sends samples to a simulated device at absolute deadlines, on its own thread.

    By default no sample is skipped: after a delay the late ones follow at once, as from a
    buffer.
    """

    def __init__(
        self,
        device: SimulatedDevice,
        rate_hz: float,
        clock: Clock | None = None,
        *,
        fault: Fault | None = None,
        is_attended: bool = True,
    ) -> None:
        """Prepare to send `rate_hz` samples per second, stamped with the clock's date.

        Args:
            device: Device that sends them.
            rate_hz: Samples per second.
            clock: Clock whose date is the stamp.
            fault: Replaces each sample.
            is_attended: Whether a reader is present, so that sending waits for a full link.
                Otherwise a sample is not sent if a `PluggableDevice` has no room.
        """
        self._device = device
        self._rate_hz = rate_hz
        self._clock = clock or SystemClock()
        self._fault = fault
        self._room = None if is_attended or not isinstance(device, PluggableDevice) else device
        self._thread: threading.Thread | None = None
        # Held until the simulator is to stop, so that waiting for it is a wait for the end.
        self._stop = threading.Lock()
        self._due = 0
        self.sent = 0
        """Number of samples sent so far."""

    def start(self) -> None:
        """Start sending, or go on after a stop. Do nothing while sending."""
        if self._thread is not None:
            return
        self._stop.acquire()
        self._thread = background_thread(self._run, "imu-simulator")
        self._thread.start()

    def stop(self) -> None:
        """Stop sending. Do nothing if it has stopped, or never started."""
        if self._thread is None:
            return
        self._stop.release()
        self._thread.join(_PATIENCE_S)
        if self._thread.is_alive():
            # It waits for a link that nobody empties any more.
            self._device.close()
            self._thread.join()
        self._thread = None

    def _run(self) -> None:
        wait = self._clock.waiter(self._stop)
        start_ns = self._clock.monotonic_ns() - int(self._due / self._rate_hz * _NS_PER_S)
        while True:
            due_s = self._due / self._rate_hz
            wait_ns = start_ns + int(due_s * _NS_PER_S) - self._clock.monotonic_ns()
            if wait(max(0.0, wait_ns / _NS_PER_S)):
                self._stop.release()
                return
            try:
                self._send(payload_at(due_s, self._clock.now()))
            except TransportError:
                return

    def _send(self, payload: bytes) -> None:
        number, self._due = self._due, self._due + 1
        if self._room is not None and not self._room.has_room:
            return
        for piece in (payload,) if self._fault is None else self._fault(number, payload):
            self._device.send(piece)
        self.sent += 1
