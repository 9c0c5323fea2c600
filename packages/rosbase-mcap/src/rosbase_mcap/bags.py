"""Recordings of any origin as messages in their order: MCAP, and what `rosbags` reads."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import BinaryIO, NamedTuple, Protocol

from attrs import frozen

from rosbase_mcap.channel_table import CDR
from rosbase_mcap.commands.opened import opened
from rosbase_mcap.cutting import is_latched
from rosbase_mcap.reading import Selection, contents, messages, read_summary
from rosbase_mcap.records import Channel, Schema

__all__ = ["Bag", "BagMessage", "BagTopic", "is_mcap", "open_bag"]

_MCAP = ".mcap"


class BagMessage(NamedTuple):
    """A message of a bag."""

    topic: str
    log_ns: int
    """When it was recorded, in nanoseconds since 1970."""
    data: bytes
    """The message as CDR."""


@frozen
class BagTopic:
    """A topic of a bag."""

    type_name: str
    """Type of its messages, such as `sensor_msgs/msg/Imu`."""
    is_latched: bool = False
    """Whether its publishers kept messages for those who came later."""


class Bag(Protocol):
    """A recording that is open."""

    @property
    def topics(self) -> Mapping[str, BagTopic]:
        """Its topics by full name; those whose messages are not CDR are left out."""
        ...

    @property
    def start_ns(self) -> int:
        """Date of its first message, in nanoseconds since 1970; 0 if it has none."""
        ...

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """Yield the messages of some topics, in the order of the bag."""
        ...


def is_mcap(path: Path) -> bool:
    """Return whether a recording is an MCAP file, by its name; a folder of rosbag2 is none."""
    return path.suffix == _MCAP and not path.is_dir()


def open_bag(path: Path) -> AbstractContextManager[Bag]:
    """Open a bag: an MCAP file, a file or folder of rosbag2, or a file of ROS 1.

    Raises:
        McapError: It cannot be read.
        NotInstalledError: It is no MCAP file, and `rosbags` is not installed.
    """
    if is_mcap(path):
        return _open_mcap(path)
    from rosbase_mcap.foreign_bags import open_foreign_bag

    return open_foreign_bag(path)


@contextmanager
def _open_mcap(path: Path) -> Iterator[Bag]:
    with opened(path) as stream:
        yield _McapBag(stream)


class _McapBag:
    """An MCAP file, which may have been cut off."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self.topics = {
            channel.topic: BagTopic(schema.name, is_latched(channel))
            for channel, schema in _channels(stream)
            if channel.message_encoding == CDR
        }

    @property
    def start_ns(self) -> int:
        """Date of the first message; 0 if there is none."""
        summary = read_summary(self._stream)
        if summary is not None:
            return summary.start_ns or 0
        return next((entry.message.log_ns for entry in messages(self._stream)), 0)

    def messages(self, topics: Collection[str]) -> Iterator[BagMessage]:
        """Yield the messages of some topics, in the order of the file."""
        known = frozenset(topics) & self.topics.keys()
        # No topic at all would be all of them.
        for entry in messages(self._stream, Selection(known)) if known else ():
            yield BagMessage(entry.channel.topic, entry.message.log_ns, entry.message.data)


def _channels(stream: BinaryIO) -> Iterator[tuple[Channel, Schema]]:
    summary = read_summary(stream)
    channels = dict(summary.channels) if summary else {}
    schemas = dict(summary.schemas) if summary else {}
    if summary is None:
        for content in contents(stream):
            if isinstance(content, Channel):
                channels[content.id] = content
            elif isinstance(content, Schema):
                schemas[content.id] = content
    for channel in channels.values():
        if channel.schema_id in schemas:
            yield channel, schemas[channel.schema_id]
