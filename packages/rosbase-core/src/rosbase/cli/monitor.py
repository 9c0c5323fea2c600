"""Listens to what the reader publishes: how much, how late, and what was last."""

import json
from collections.abc import Callable
from typing import Any

import attrs

from rosbase.histogram import Histogram
from rosbase.messages import Imu
from rosbase.node import BaseNode

__all__ = ["SampleMonitor", "imu_to_json"]

# Ten seconds of a fast IMU, for a terminal or a pipe that stalls.
_DEPTH = 10_000


def imu_to_json(message: Imu) -> str:
    """The message as one line of JSON, with the names of sensor_msgs/Imu."""
    return json.dumps(attrs.asdict(message), separators=(",", ":"), allow_nan=False)


class SampleMonitor(BaseNode):
    """Subscribes to the topics of one reader."""

    def __init__(
        self,
        manager: Any = None,
        *args: Any,
        topic_namespace: str = "imu",
        echo: Callable[[str], object] | None = None,
        **kwargs: Any,
    ) -> None:
        """Subscribes; with `echo`, hands it each sample as a line of JSON."""
        super().__init__(manager, *args, **kwargs)
        self._now_ns = self.get_clock().now_ns
        self._echo = echo
        self.last: Imu | None = None
        """The last sample."""
        self.latency = Histogram()
        """Nanoseconds from the stamp of each sample to its arrival here."""
        self._subscriptions = [
            self.create_subscription(Imu, f"{topic_namespace}/{name}", self._take, _DEPTH)
            for name in ("data", "data_raw")
        ]

    @property
    def dropped(self) -> int:
        """Samples that were published and did not get here in time."""
        return sum(subscription.dropped for subscription in self._subscriptions)

    def _take(self, message: Imu) -> None:
        self.latency.record(self._now_ns() - message.header.stamp.nanoseconds)
        self.last = message
        if self._echo is not None:
            self._echo(imu_to_json(message))
