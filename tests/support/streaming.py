"""A simulated device that sends samples all the time, on a thread of its own."""

import itertools
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from rosbase.contracts.transport import SimulatedDevice
from rosbase.errors import TransportError
from rosbase.imu.simulator import payload_at
from rosbase.messages import Time

__all__ = ["streaming"]


@contextmanager
def streaming(device: SimulatedDevice, *, period_s: float = 0.02, sec: int = 7) -> Iterator[None]:
    """Sends samples of a device that moves, and closes it at the end.

    Args:
        device: Sends them.
        period_s: The time between two of them.
        sec: The seconds of their stamps; the nanoseconds count them, from 0.
    """
    stop = threading.Event()

    def stream() -> None:
        for number in itertools.count():
            if stop.wait(period_s):
                return
            try:
                device.send(payload_at(number * period_s, Time(sec, number)))
            except TransportError:
                return

    thread = threading.Thread(target=stream)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        # Nobody may be left to read what it sends.
        device.close()
        thread.join()
