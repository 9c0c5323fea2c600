"""What is a line framer's own; the rest is in test_line_framer_contract.py."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.framing import Frame, FrameError, LineFramer

# Mostly what matters to a line framer.
streams = st.lists(
    st.sampled_from([b"\r", b"\n", b"\r\n", b"\x00", b" ", b"\t", b"a", b"{}", b"x" * 9])
    | st.binary(max_size=6),
    max_size=40,
).map(b"".join)


def outcome(chunks: list[bytes], limit: int) -> list[object]:
    framer = LineFramer(limit)
    events = [event for chunk in chunks for event in framer.feed(chunk, 0)]
    return [event.data if isinstance(event, Frame) else event.reason for event in events]


@given(streams, st.integers(1, 12))
def test_frames_are_never_longer_than_the_limit_nor_empty(stream: bytes, limit: int) -> None:
    for event in LineFramer(limit).feed(stream, 0):
        if isinstance(event, Frame):
            assert 0 < len(event.data) <= limit
            assert not set(event.data) & set(b"\r\n")


@pytest.mark.parametrize("ending", [b"\n", b"\r\n", b"\r", b"\n\r\n\n"])
def test_every_line_ending_ends_a_line(ending: bytes) -> None:
    assert outcome([b"one" + ending + b"two" + ending], 64) == [b"one", b"two"]


def test_padding_around_a_line_is_not_part_of_it() -> None:
    assert outcome([b"\x00\x00 {} \t\x00\n \x00\n"], 64) == [b"{}"]


def test_an_overlong_line_is_one_error_and_the_next_line_comes_through() -> None:
    chunks = [b"x" * 40, b"x" * 40, b"x\n", b"{}\n"]
    assert outcome(chunks, 64) == ["overlong", b"{}"]


def test_padding_before_a_line_does_not_count_as_its_first_byte() -> None:
    framer = LineFramer()
    framer.feed(b"\n\x00\x00", 100)
    assert framer.feed(b"{}\n", 200) == [Frame(b"{}", 200)]


def test_the_error_is_stamped_when_the_lost_line_began() -> None:
    framer = LineFramer(4)
    framer.feed(b"xx", 100)
    assert framer.feed(b"xxxxx\n", 200) == [FrameError("overlong", 100)]


def test_a_limit_below_one_byte_is_refused() -> None:
    with pytest.raises(ValueError, match="max_line_bytes"):
        LineFramer(0)


@given(st.lists(st.binary(max_size=30)))
def test_pending_bytes_are_those_behind_the_last_end_of_a_line(chunks: list[bytes]) -> None:
    framer = LineFramer(max_line_bytes=10)
    fed = b""
    for chunk in chunks:
        framer.feed(chunk, 0)
        fed += chunk
        assert framer.pending_bytes == len(fed.replace(b"\r", b"\n").rpartition(b"\n")[2])
    framer.reset()
    assert framer.pending_bytes == 0
