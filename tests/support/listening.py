"""A plain rclpy subscriber, in a process of its own that knows nothing of rosbase."""

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from support.command import Lines

__all__ = ["WARM_UP_S", "Listener", "listening"]

# Of this day, or the reader would ask for more than one sample with such a date.
WARM_UP_S = int(time.time()) - 3600
"""The seconds in the stamps of samples that only find out whether somebody listens."""

_PROGRAM = Path(__file__).with_name("ros_listener.py")


class Listener:
    """What the process has heard of a topic."""

    def __init__(self, topic: str, depth: int) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(_PROGRAM), topic, str(depth)], stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdout is not None
        self.out = Lines(self._process.stdout)

    def close(self) -> None:
        """Ends the process."""
        self._process.kill()
        self._process.wait()
        self.out.join()
        assert self._process.stdout is not None
        self._process.stdout.close()

    @property
    def heard(self) -> list[dict[str, Any]]:
        """The messages so far, without those of the warm-up."""
        messages = [json.loads(line) for line in list(self.out.lines)]
        return [message for message in messages if message["stamp"][0] != WARM_UP_S]


@contextmanager
def listening(topic: str = "/imu/data") -> Iterator[Listener]:
    """Listens to a topic."""
    listener = Listener(topic, 10_000)
    try:
        yield listener
    finally:
        listener.close()
