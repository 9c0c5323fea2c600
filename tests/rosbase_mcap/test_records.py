"""Records as bytes and back, and the bytes that the specification shows."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase_mcap.errors import McapError
from rosbase_mcap.layout import Cursor
from rosbase_mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    Footer,
    Header,
    Kind,
    Message,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    record,
)

RECORDS: list[Any] = [
    Header("ros2", "library"),
    Schema(1, "std_msgs/msg/String", "ros2msg", b"string data"),
    Channel(0, 1, "/chatter", "cdr", {"offered_qos_profiles": "", "é": "ü"}),
    Message(3, 4, 5, 6, b"data"),
    Chunk(1, 2, 3, 4, "lz4", b"abc"),
    ChunkIndex(1, 2, 3, 4, {5: 6, 7: 8}, 9, "zstd", 10, 11),
    Attachment(1, 2, "params.yaml", "text/yaml", b"a: 1"),
    AttachmentIndex(1, 2, Attachment(3, 4, "name", "type", b""), 5),
    Metadata("rosbase", {"python": "3.11"}),
    MetadataIndex(1, 2, "rosbase"),
    Statistics(1, 2, 3, 4, 5, 6, 7, 8, {9: 10}),
    Footer(1, 2, 3),
]


@pytest.mark.parametrize("one", RECORDS, ids=lambda one: type(one).__name__)
def test_a_record_is_read_as_it_was_written(one: Any) -> None:
    assert type(one).read(one.content()) == one


@pytest.mark.parametrize("one", RECORDS, ids=lambda one: type(one).__name__)
def test_a_record_that_ends_too_early_is_an_error_and_nothing_else(one: Any) -> None:
    content = one.content()
    for length in range(len(content)):
        try:
            type(one).read(content[:length])
        except McapError:
            continue
        # What is last may be short, or left out.
        assert isinstance(one, Message | Attachment)


def test_a_record_has_its_kind_and_the_length_of_its_content_in_front() -> None:
    assert record(Kind.METADATA, b"ab") == b"\x0c\x02\0\0\0\0\0\0\0ab"


@given(st.binary(max_size=60))
def test_hostile_bytes_are_an_error_and_nothing_else(data: bytes) -> None:
    for one in RECORDS:
        try:
            type(one).read(data)
        except McapError:
            pass


def test_a_length_that_is_a_lie_allocates_nothing() -> None:
    with pytest.raises(McapError, match="4294967295 bytes expected, 0 left"):
        Cursor(b"\xff\xff\xff\xff").text()
