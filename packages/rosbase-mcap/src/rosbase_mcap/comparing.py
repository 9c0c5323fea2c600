"""The first difference between two recordings, such as of a run and of its replay."""

from collections.abc import Collection, Iterator
from itertools import zip_longest
from typing import Any, BinaryIO

from attrs import frozen

from rosbase.errors import WireError
from rosbase.wire.plain import decoder
from rosbase_mcap.channel_table import CDR, ROS2MSG
from rosbase_mcap.csv_export import columns
from rosbase_mcap.facts_text import span_text
from rosbase_mcap.reading import Entry, messages

__all__ = ["Difference", "first_difference"]

_NOTHING = "nothing"


@frozen
class Difference:
    """Where two recordings begin to differ."""

    topic: str
    log_ns: int
    """When the message was recorded, in nanoseconds since 1970."""
    field: str
    """Name of the field, such as `angular_velocity.x`; of all of the message, empty."""
    before: str
    """Its value in the first recording."""
    after: str
    """Its value in the second."""
    number: int
    """How many messages before it are the same."""
    since_ns: int
    """Time since the first message, in nanoseconds."""

    def __str__(self) -> str:
        """Return it as lines for people."""
        name = f"{self.topic} {self.field}".rstrip()
        where = f"after {span_text(self.since_ns)} and {self.number} equal messages"
        return f"{name}, {where}:\n  - {self.before}\n  + {self.after}"


def first_difference(
    before: BinaryIO, after: BinaryIO, *, leave_out: Collection[str] = ()
) -> Difference | None:
    """Return where two recordings begin to differ; None if their messages are the same.

    The same are the order of all messages, their topics, types and bytes, and when they were
    recorded.

    Args:
        before: The first recording.
        after: The second.
        leave_out: Topics that may differ.

    Raises:
        NotMcapError: One of them is no recording.
    """
    start_ns = 0
    pairs = zip_longest(_kept(before, leave_out), _kept(after, leave_out))
    for number, (one, other) in enumerate(pairs):
        found = one or other
        # One of them is there, but the checker of types cannot know.
        assert found is not None
        start_ns = found.message.log_ns if number == 0 else start_ns
        if one is None or other is None or _key(one) != _key(other):
            field, old, new = _difference(one, other)
            log_ns = found.message.log_ns
            place = found.channel.topic, log_ns
            return Difference(*place, field, old, new, number, max(0, log_ns - start_ns))
    return None


def _kept(stream: BinaryIO, leave_out: Collection[str]) -> Iterator[Entry]:
    return (entry for entry in messages(stream) if entry.channel.topic not in leave_out)


def _key(entry: Entry) -> tuple[str, str, int, bytes]:
    name = entry.schema.name if entry.schema else ""
    return entry.channel.topic, name, entry.message.log_ns, entry.message.data


def _difference(one: Entry | None, other: Entry | None) -> tuple[str, str, str]:
    """Return the field that differs, with both values."""
    if one is None or other is None or one.channel.topic != other.channel.topic:
        return "", _named(one), _named(other)
    if one.schema and other.schema and one.schema.name != other.schema.name:
        return "", one.schema.name, other.schema.name
    if one.message.data == other.message.data:
        return "log time", f"{one.message.log_ns} ns", f"{other.message.log_ns} ns"
    old, new = _fields(one), _fields(other)
    for name in dict.fromkeys([*old, *new]):
        values = old.get(name, _NOTHING), new.get(name, _NOTHING)
        if repr(values[0]) != repr(values[1]):
            return name, str(values[0]), str(values[1])
    return "", one.message.data.hex(" "), other.message.data.hex(" ")


def _named(entry: Entry | None) -> str:
    if entry is None:
        return _NOTHING
    return f"{entry.channel.topic} at {entry.message.log_ns} ns"


def _fields(entry: Entry) -> dict[str, Any]:
    """Return the fields of a message by name; none if it cannot be read."""
    channel, schema = entry.channel, entry.schema
    if schema is None or (channel.message_encoding, schema.encoding) != (CDR, ROS2MSG):
        return {}
    try:
        read = decoder(schema.name, str(schema.data, "utf-8", "replace"))
        return dict(columns(read(entry.message.data)))
    except WireError:
        return {}
