"""Chunks as a sink gets them."""

from collections.abc import Iterable

from rosbase_mcap.chunks import OpenChunk, contents_of
from rosbase_mcap.records import Message

__all__ = ["messages_in", "open_chunk"]


def open_chunk(channel: int, stamps: Iterable[int], data: bytes = b"") -> OpenChunk:
    """A chunk with a message for each of these times, in nanoseconds."""
    found = OpenChunk()
    for stamp in stamps:
        found.add(channel, stamp, stamp, stamp, data)
    return found


def messages_in(chunks: Iterable[OpenChunk]) -> list[Message]:
    """The messages of chunks, in their order."""
    found = [one for chunk in chunks for one in contents_of(chunk.records)]
    assert all(isinstance(one, Message) for one in found)
    return [one for one in found if isinstance(one, Message)]
