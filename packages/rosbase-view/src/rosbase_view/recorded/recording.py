"""Contract for a recording that is played."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, Protocol

from attrs import frozen

__all__ = ["RecordedMessage", "RecordedTopic", "Recording"]


@frozen
class RecordedTopic:
    """A topic of a recording."""

    name: str
    type: str
    """Such as `sensor_msgs/msg/Imu`."""
    schema: str
    """Text of `ros2msg`."""


class RecordedMessage(NamedTuple):
    """A message of a recording."""

    topic: str
    stamp_ns: int
    """When it was recorded, in nanoseconds since 1970."""
    data: bytes
    """The message as CDR."""


class Recording(Protocol):
    """Is read by one thread."""

    @property
    def begin_ns(self) -> int:
        """Return when the first message was recorded, in nanoseconds since 1970."""
        ...

    @property
    def end_ns(self) -> int:
        """Return when the last message was recorded, in nanoseconds since 1970."""
        ...

    @property
    def topics(self) -> Sequence[RecordedTopic]:
        """Return the topics whose messages can be read."""
        ...

    def messages(self, from_ns: int) -> Iterator[RecordedMessage]:
        """Yield the messages from a time on, in the order in which they were recorded."""
        ...

    def latest(self, before_ns: int) -> Sequence[RecordedMessage]:
        """Return the last message of each topic before a time: what was known then."""
        ...

    def close(self) -> None:
        """Close the file. Idempotent."""
        ...
