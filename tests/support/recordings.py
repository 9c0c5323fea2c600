"""Recordings for tests: made, and read in the plainest way."""

from collections.abc import Iterable
from io import BytesIO
from typing import NamedTuple

from hypothesis import strategies as st

from rosbase_mcap.file_writer import FileWriter
from rosbase_mcap.reading import messages
from rosbase_mcap.records import Attachment, Channel, Message, Metadata, Schema

SCHEMA = Schema(1, "std_msgs/msg/String", "ros2msg", b"string data")
CHANNELS = [Channel(number, 1, f"/topic_{number}", "cdr", {}) for number in range(3)]


class Written(NamedTuple):
    """A file, with what must be in it."""

    data: bytes
    messages: list[Message]
    """All of its messages, in its order."""
    ends: list[tuple[int, int]]
    """For each record with messages: where it ends, and how many messages end there at most."""


_stamps = st.integers(0, 2**64 - 1)
_messages = st.builds(
    Message, st.integers(0, 2), st.integers(0, 2**32 - 1), _stamps, _stamps, st.binary(max_size=40)
)
_asides = st.one_of(
    st.builds(Attachment, _stamps, _stamps, st.text(max_size=5), st.just("x"), st.binary()),
    st.builds(Metadata, st.text(max_size=5), st.dictionaries(st.text(), st.text(), max_size=3)),
)
chunks = st.lists(st.one_of(st.lists(_messages, max_size=6), _asides), max_size=6)
"""What goes into a file: chunks, and what is between them."""


def written(parts: Iterable[list[Message] | Attachment | Metadata], compression: str) -> Written:
    """Returns the file with these parts."""
    pieces: list[bytes | memoryview] = []
    writer = FileWriter(pieces.append, compression=compression, library="test")
    sent: list[Message] = []
    ends = []
    for part in parts:
        if isinstance(part, Attachment):
            writer.attach(part)
        elif isinstance(part, Metadata):
            writer.note(part)
        else:
            for one in part:
                writer.declare(CHANNELS[one.channel_id], SCHEMA)
                writer.add(one.channel_id, one.sequence, one.log_ns, one.publish_ns, one.data)
            sent += part
            writer.end_chunk()
            chunk = writer.summary.chunks[-1] if part else None
            if chunk is not None:
                ends.append((chunk.offset + chunk.length, len(sent)))
    writer.finish()
    return Written(b"".join(pieces), sent, ends)


def read(data: bytes) -> list[Message]:
    """Returns the messages of a file."""
    return [entry.message for entry in messages(BytesIO(data))]
