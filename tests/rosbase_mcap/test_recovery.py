"""Files that were cut off or damaged, and what is left of them."""

from io import BytesIO

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase_mcap.errors import NotMcapError
from rosbase_mcap.reading import read_summary
from rosbase_mcap.records import MAGIC, Attachment, Message, Metadata
from rosbase_mcap.recovery import Mended, is_complete, mend
from support.recordings import chunks, read, written

COMPRESSIONS = ("", "lz4", "zstd")
THREE = [[Message(0, number, number, number, b"x" * 30)] * 2 for number in range(3)]


def mended(data: bytes) -> tuple[bytes, Mended]:
    pieces: list[bytes | memoryview] = []
    outcome = mend(BytesIO(data), pieces.append)
    return b"".join(pieces), outcome


@given(chunks, st.sampled_from(COMPRESSIONS), st.data())
def test_any_prefix_recovers_to_all_messages_of_its_whole_chunks(
    parts: list[list[Message] | Attachment | Metadata], compression: str, data: st.DataObject
) -> None:
    whole = written(parts, compression)
    length = data.draw(st.integers(len(MAGIC), len(whole.data)))
    found, outcome = mended(whole.data[:length])
    assert is_complete(BytesIO(found))
    least = max((number for end, number in whole.ends if end <= length), default=0)
    messages = read(found)
    assert len(messages) >= least
    # No other ones, and in their order.
    assert messages == whole.messages[: len(messages)]
    assert outcome.summary.messages == len(messages)
    assert not outcome.damaged_chunks


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_mended_file_has_an_index_of_all_that_is_in_it(compression: str) -> None:
    whole = written([*THREE, Metadata("a", {}), Attachment(1, 2, "b", "c", b"d")], compression)
    # Without its end.
    found, _ = mended(whole.data[:-1])
    summary, before = read_summary(BytesIO(found)), read_summary(BytesIO(whole.data))
    assert summary is not None
    assert before is not None
    assert summary.statistics == before.statistics
    assert found == whole.data


def test_the_messages_of_a_chunk_that_was_cut_off_are_kept_if_it_is_not_compressed() -> None:
    whole = written(THREE, "")
    end, _ = whole.ends[-1]
    found, outcome = mended(whole.data[: end - 1])
    # All but the one that is not whole.
    assert read(found) == whole.messages[:-1]
    assert outcome.lost_bytes > 0


def test_a_damaged_chunk_is_left_out_and_counted() -> None:
    whole = written(THREE, "")
    end, _ = whole.ends[0]
    damaged = bytearray(whole.data)
    damaged[end - 1] ^= 0xFF
    found, outcome = mended(bytes(damaged))
    assert outcome.damaged_chunks == 1
    assert read(found) == whole.messages[2:]


def test_zeros_after_a_loss_of_power_end_the_file() -> None:
    whole = written(THREE, "")
    end, _ = whole.ends[0]
    found, _ = mended(whole.data[:end] + bytes(4096))
    assert read(found) == whole.messages[:2]


def test_a_complete_file_stays_as_it_is() -> None:
    whole = written(THREE, "lz4")
    found, outcome = mended(whole.data)
    assert found == whole.data
    assert outcome.lost_bytes == 0


def test_a_file_with_nothing_in_it_becomes_an_empty_recording() -> None:
    found, outcome = mended(MAGIC)
    assert is_complete(BytesIO(found))
    assert outcome.summary.messages == 0


@pytest.mark.parametrize("data", [b"", MAGIC[:-1], b"SQLite format 3\0"])
def test_what_is_no_recording_is_said_to_be_none(data: bytes) -> None:
    with pytest.raises(NotMcapError):
        mended(data)


@given(st.binary(max_size=200))
def test_hostile_bytes_are_mended_too(data: bytes) -> None:
    found, _ = mended(MAGIC + data)
    assert is_complete(BytesIO(found))
