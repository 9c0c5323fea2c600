"""Copy a part of a file: some topics, or some time."""

from typing import BinaryIO

from rosbase_mcap.channel_table import LATCHED
from rosbase_mcap.file_writer import FileWriter, Write
from rosbase_mcap.reading import Selection, contents
from rosbase_mcap.records import Attachment, Channel, Metadata, Schema
from rosbase_mcap.traces import BROKEN, END, RUN, is_trace

__all__ = ["cut", "is_latched"]

_TRANSIENT_LOCAL = "durability: 1"
_TRANSIENT_LOCAL_WORD = "durability: transient_local"


def cut(
    stream: BinaryIO,
    write: Write,
    selection: Selection,
    *,
    profile: str = "ros2",
    compression: str = "",
) -> int:
    """Write a part of a file as a file of its own; return the number of messages.

    Of latched topics, such as /tf_static, earlier messages are kept too, because the others are
    hard to read without them. Attachments and metadata are kept, except the entries of a program:
    they can only be replayed as a whole.

    Raises:
        NotMcapError: The file does not begin as an MCAP file does.
    """
    writer = FileWriter(write, profile=profile, compression=compression)
    channels: dict[int, Channel] = {}
    schemas: dict[int, Schema] = {}
    early = Selection(selection.topics, None, selection.end_ns)
    for content in contents(stream):
        if isinstance(content, Schema):
            schemas[content.id] = content
        elif isinstance(content, Channel):
            channels[content.id] = content
        elif isinstance(content, Attachment):
            if not is_trace(content):
                writer.attach(content)
        elif isinstance(content, Metadata):
            if content.name not in (RUN, END, BROKEN):
                writer.note(content)
        else:
            channel = channels.get(content.channel_id)
            if channel is None:
                continue
            wanted = early if is_latched(channel) else selection
            if wanted.has(channel, content.log_ns):
                writer.declare(channel, schemas.get(channel.schema_id))
                times = content.log_ns, content.publish_ns
                writer.add(channel.id, content.sequence, *times, content.data)
    writer.finish()
    return writer.summary.messages


def is_latched(channel: Channel) -> bool:
    """Return whether publishers of a channel kept messages for those who came later."""
    profiles = channel.metadata.get("offered_qos_profiles", "")
    named = _TRANSIENT_LOCAL in profiles or _TRANSIENT_LOCAL_WORD in profiles
    return named or LATCHED in channel.metadata
