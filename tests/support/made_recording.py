"""A recording that is made as it is read: Imus at 100 Hz, and a text that comes once.

It may have a log too, with a record each second.
"""

import math
from collections.abc import Iterator, Sequence

from rosbase.messages import Header, Imu, Quaternion, String, Time
from rosbase.messages.rcl_interfaces import Log
from rosbase.wire import schema, serialize
from rosbase_view.recorded.recording import RecordedMessage, RecordedTopic

__all__ = ["BEGIN_NS", "STEP_NS", "MadeRecording", "number_of"]

BEGIN_NS = 1_700_000_000_000_000_000
STEP_NS = 10_000_000
_IMU, _MODEL, _LOG = "/imu/data", "/model", "/rosout"


class MadeRecording:
    """Counts its messages from 0; the stamp of an Imu is its number."""

    def __init__(self, count: int, padding: int = 0, *, has_log: bool = False) -> None:
        """Makes a recording.

        Args:
            count: Number of Imus.
            padding: Number of bytes that each one has besides.
            has_log: Whether there is a log.
        """
        self._count, self._padding = count, padding
        self.begin_ns, self.end_ns = BEGIN_NS, BEGIN_NS + (count - 1) * STEP_NS
        self.topics = [
            RecordedTopic(_IMU, "sensor_msgs/msg/Imu", schema(Imu)),
            RecordedTopic(_MODEL, "std_msgs/msg/String", schema(String)),
        ]
        self._has_log = has_log
        if has_log:
            self.topics.append(RecordedTopic(_LOG, "rcl_interfaces/msg/Log", schema(Log)))
        self.is_closed = False
        self.read = 0
        """Messages that were read."""

    def messages(self, from_ns: int) -> Iterator[RecordedMessage]:
        if from_ns <= BEGIN_NS:
            yield self._model()
        for number in range(max(0, -(-(from_ns - BEGIN_NS) // STEP_NS)), self._count):
            self.read += 1
            yield self._imu(number)
            if self._has_log and number % 100 == 0:
                yield self._record(number)

    def latest(self, before_ns: int) -> Sequence[RecordedMessage]:
        if before_ns <= BEGIN_NS:
            return []
        last = min(self._count - 1, (before_ns - BEGIN_NS - 1) // STEP_NS)
        return [self._model(), self._imu(last)]

    def close(self) -> None:
        self.is_closed = True

    def _model(self) -> RecordedMessage:
        return RecordedMessage(_MODEL, BEGIN_NS, bytes(serialize(String("a board"))))

    def _record(self, number: int) -> RecordedMessage:
        time_ns = BEGIN_NS + number * STEP_NS
        seconds, rest_ns = divmod(time_ns, 1_000_000_000)
        record = Log(Time(seconds, rest_ns), 30, "imu", f"record {number // 100}")
        return RecordedMessage(_LOG, time_ns, bytes(serialize(record)))

    def _imu(self, number: int) -> RecordedMessage:
        header = Header(Time(number, 0), "x" * self._padding or "imu_link")
        turned = Quaternion(0.0, 0.0, math.sin(number / 200.0), math.cos(number / 200.0))
        data = bytes(serialize(Imu(header, turned)))
        return RecordedMessage(_IMU, BEGIN_NS + number * STEP_NS, data)


def number_of(data: bytes) -> int:
    """The number of an Imu in CDR."""
    return int.from_bytes(data[4:8], "little")
