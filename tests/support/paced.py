"""A device that sends numbered samples at a rate, and when it sent each of them."""

import json
import os
import threading
import time
import tty
from collections.abc import Callable
from typing import Any, NamedTuple

from support.samples import frame

__all__ = ["Echoed", "Paced", "Uart", "echoed"]


class Uart:
    """A line that loses what nobody reads, as a UART does, and does not keep the sender waiting."""

    def __init__(self) -> None:
        self._fd, self._far_end = os.openpty()
        tty.setraw(self._far_end)
        os.set_blocking(self._fd, False)
        self.path = os.ttyname(self._far_end)

    def write(self, data: bytes) -> None:
        try:
            os.write(self._fd, data)
        except BlockingIOError:
            # It overruns.
            pass

    def close(self) -> None:
        os.close(self._fd)
        os.close(self._far_end)


class Paced:
    """Sends samples, several at a time, on a thread of its own until it is ended.

    A sample's number is its angular velocity about x, in thousandths.
    """

    def __init__(self, send: Callable[[bytes], object], hz: float, together: int = 1) -> None:
        self._send, self._interval_s, self._together = send, together / hz, together
        self.sent_ns: list[int] = []
        """By number: when it was sent."""
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def end(self) -> None:
        self._ends.set()
        self._thread.join(20)

    def _run(self) -> None:
        due_s = time.monotonic()
        while not self._ends.wait(max(0.0, due_s - time.monotonic())):
            first = len(self.sent_ns)
            lines = [
                frame(angular_velocity={"x": number / 1000, "y": 0.0, "z": 0.0}) + b"\n"
                for number in range(first, first + self._together)
            ]
            self.sent_ns += [time.time_ns()] * self._together
            self._send(b"".join(lines))
            due_s += self._interval_s


class Echoed(NamedTuple):
    """A sample that `rosbase imu --topic-echo` has printed."""

    number: int
    stamp_ns: int


def echoed(lines: list[str]) -> list[Echoed]:
    """The samples in the lines, those of a `Paced` device."""
    return [_echoed(json.loads(line)) for line in lines]


def _echoed(sample: Any) -> Echoed:
    stamp = sample["header"]["stamp"]
    stamp_ns = stamp["sec"] * 1_000_000_000 + stamp["nanosec"]
    return Echoed(round(sample["angular_velocity"]["x"] * 1000), stamp_ns)
