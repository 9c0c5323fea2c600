"""Outputs of a made-up run, as the bytes of a recording."""

from collections.abc import Iterable, Mapping, Sequence

from rosbase_mcap.channel_table import CDR, ORIGIN, OUTSIDE
from rosbase_mcap.chunks import OpenChunk
from rosbase_mcap.outputs import Output
from rosbase_mcap.records import Channel, Kind, Schema, record
from rosbase_mcap.replaying.recorded_outputs import RecordedOutputs

__all__ = ["chunk", "declarations", "recorded_outputs"]


def recorded_outputs(outputs: Iterable[Output], schemas: Mapping[str, Schema]) -> RecordedOutputs:
    """Outputs of one file with one chunk."""
    topics = list(schemas)
    return RecordedOutputs([[declarations(schemas), chunk(outputs, topics)]])


def declarations(schemas: Mapping[str, Schema], outside: Sequence[str] = ()) -> bytes:
    """Schema and channel records; a channel's number is the index of its topic."""
    found = b""
    for number, (topic, schema) in enumerate(schemas.items()):
        channel = Channel(number, schema.id, topic, CDR)
        found += record(Kind.SCHEMA, schema.content()) + record(Kind.CHANNEL, channel.content())
    for number, topic in enumerate(outside, len(schemas)):
        channel = Channel(number, 0, topic, CDR, {ORIGIN: OUTSIDE})
        found += record(Kind.CHANNEL, channel.content())
    return found


def chunk(outputs: Iterable[Output], topics: Sequence[str]) -> bytes:
    """Message records; the channel of each is the index of its topic."""
    found = OpenChunk()
    for one in outputs:
        found.add(topics.index(one.topic), one.number, one.log_ns, one.log_ns, one.data)
    return bytes(found.records)
