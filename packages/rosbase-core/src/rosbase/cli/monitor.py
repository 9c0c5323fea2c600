"""Listen to the reader's topics: message counts, latency and the last sample."""

import json
import math
from collections.abc import Callable
from typing import Any, cast

import attrs

from rosbase.messages import Imu, MagneticField
from rosbase.roles.node import BaseNode
from rosbase.runtime.histogram import Histogram

__all__ = ["SampleMonitor", "message_to_json"]

_encode = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode

# Ten seconds of a fast IMU, for a terminal or a pipe that stalls.
_DEPTH = 10_000


def message_to_json(message: Imu | MagneticField) -> str:
    """Return the message as one line of JSON, with the field names of sensor_msgs.

    JSON has no number for infinities and NaN, which other publishers may send: they become
    null.
    """
    try:
        return _encode(attrs.asdict(message))
    except ValueError:
        return _encode(attrs.asdict(message, value_serializer=_finite_or_none))


def _finite_or_none(owner: object, attribute: object, value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


class SampleMonitor(BaseNode):
    """Subscribes to the topics of one reader."""

    def __init__(
        self,
        manager: Any = None,
        *args: Any,
        echo: Callable[[str], object] | None = None,
        **kwargs: Any,
    ) -> None:
        """Subscribe; with `echo`, pass each sample to it as a line of JSON."""
        super().__init__(manager, *args, **kwargs)
        # The reader is the own node of the manager.
        topic_namespace = self._backend.get_parameter("topic_namespace").value
        self._now_ns = self.get_clock().now_ns
        self._echo = echo
        self.last: Imu | MagneticField | None = None
        """Last sample."""
        self.latency = Histogram()
        """Nanoseconds from the stamp of each sample to its arrival here."""
        self._subscriptions = [
            self.create_subscription(
                cast("type[Any]", kind), f"{topic_namespace}/{name}", self._take, _DEPTH
            )
            for name, kind in (("data", Imu), ("data_raw", Imu), ("mag", MagneticField))
        ]

    @property
    def dropped(self) -> int:
        """Number of samples that were published but did not get here in time."""
        return sum(subscription.dropped for subscription in self._subscriptions)

    def _take(self, message: Imu | MagneticField) -> None:
        stamp_ns = message.header.stamp.nanoseconds
        if stamp_ns:
            # Zero says that the date of the machine was no stamp.
            self.latency.record(self._now_ns() - stamp_ns)
        self.last = message
        if self._echo is not None:
            self._echo(message_to_json(message))
