"""A chunk that is being filled."""

from zlib import crc32

import pytest

from rosbase_mcap.chunks import MESSAGE_HEAD, OpenChunk, contents_of, message_times
from rosbase_mcap.compression import unpacked
from support.coming_in import coming_in


@pytest.mark.parametrize("data", [b"", b"short", b"longer than the other"])
def test_a_message_that_is_added_while_another_one_is_loses_neither(data: bytes) -> None:
    chunk = OpenChunk()
    with coming_in(lambda: chunk.add(1, 2, 3, 4, data), behind="pack_into"):
        assert chunk.add(0, 7, 5, 6, b"the other")
    assert contents_of(chunk.records) == [(1, 2, 3, 4, data), (0, 7, 5, 6, b"the other")]
    assert chunk.times == message_times(chunk.records) == {1: [3, 0], 0: [5, 31 + len(data)]}


def test_a_message_that_is_added_meanwhile_may_take_the_last_room() -> None:
    chunk = OpenChunk(MESSAGE_HEAD.size)
    with coming_in(lambda: chunk.add(1, 2, 3, 4, b""), behind="pack_into"):
        assert not chunk.add(0, 7, 5, 6, b"")
    assert contents_of(chunk.records) == [(1, 2, 3, 4, b"")]


def test_a_message_that_is_interrupted_leaves_no_trace() -> None:
    def interrupt() -> None:
        raise KeyboardInterrupt

    chunk = OpenChunk()
    chunk.add(0, 1, 2, 3, b"before")
    with coming_in(interrupt, behind="pack_into"), pytest.raises(KeyboardInterrupt):
        chunk.add(0, 7, 5, 6, b"interrupted")
    chunk.add(0, 4, 5, 6, b"behind")
    assert contents_of(chunk.records) == [(0, 1, 2, 3, b"before"), (0, 4, 5, 6, b"behind")]
    assert chunk.times == message_times(chunk.records)


@pytest.mark.parametrize("compression", ["", "lz4", "zstd"])
def test_a_closed_chunk_has_the_records_and_the_span_of_their_times(compression: str) -> None:
    chunk = OpenChunk()
    for channel, log_ns in ((0, 7), (1, 3), (0, 9), (1, 4)):
        assert chunk.add(channel, 0, log_ns, 0, b"x" * log_ns)
    closed = chunk.close(compression)
    assert (closed.start_ns, closed.end_ns) == (3, 9)
    assert unpacked(closed) == chunk.records
    assert (closed.size_bytes, closed.crc) == (chunk.size_bytes, crc32(chunk.records))
    assert chunk.count == 4
    chunk.clear()
    assert (chunk.count, chunk.size_bytes, chunk.times) == (0, 0, {})
