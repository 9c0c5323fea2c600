"""Files as other readers find them."""

from io import BytesIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader, SeekingReader

from rosbase_mcap.reading import read_summary
from rosbase_mcap.records import Attachment, Message, Metadata
from support.recordings import CHANNELS, SCHEMA, chunks, written

COMPRESSIONS = ("", "lz4", "zstd")


def in_log_order(messages: list[Message]) -> list[tuple[int, bytes]]:
    return sorted((one.log_ns, one.data) for one in messages)


@given(chunks, st.sampled_from(COMPRESSIONS))
def test_the_reader_of_mcap_finds_every_message_by_the_index(
    parts: list[list[Message] | Attachment | Metadata], compression: str
) -> None:
    whole = written(parts, compression)
    reader = SeekingReader(BytesIO(whole.data), validate_crcs=True)
    found = [(message.log_time, message.data) for _, _, message in reader.iter_messages()]
    assert sorted(found) == in_log_order(whole.messages)
    assert len(list(reader.iter_attachments())) == sum(isinstance(p, Attachment) for p in parts)
    assert len(list(reader.iter_metadata())) == sum(isinstance(p, Metadata) for p in parts)


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_the_reader_of_mcap_finds_the_same_without_the_index(compression: str) -> None:
    whole = written([[Message(1, 2, 3, 4, b"x")], [Message(0, 0, 5, 5, b"")]], compression)
    reader = NonSeekingReader(BytesIO(whole.data), validate_crcs=True)
    found = [(message.log_time, message.data) for _, _, message in reader.iter_messages()]
    assert found == [(3, b"x"), (5, b"")]


def test_the_summary_says_what_the_reader_of_mcap_says() -> None:
    whole = written([[Message(1, 2, 3, 4, b"x"), Message(0, 0, 1, 5, b"")], Metadata("m", {})], "")
    theirs = SeekingReader(BytesIO(whole.data)).get_summary()
    ours = read_summary(BytesIO(whole.data))
    assert theirs is not None
    assert theirs.statistics is not None
    assert ours is not None
    assert (ours.start_ns, ours.end_ns) == (1, 3)
    assert theirs.statistics.message_start_time == 1
    assert theirs.statistics.channel_message_counts == dict(ours.counts) == {0: 1, 1: 1}
    assert {channel.topic for channel in theirs.channels.values()} == {"/topic_0", "/topic_1"}


def test_a_channel_is_written_once() -> None:
    whole = written([[Message(0, 0, 1, 1, b"")]] * 3, "")
    # In the data, and in the summary.
    assert whole.data.count(CHANNELS[0].topic.encode()) == 2
    assert whole.data.count(SCHEMA.data) == 2
