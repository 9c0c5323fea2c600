"""The frames of the control protocol: whatever bytes come, nothing but ControlError."""

import json
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosbase import ControlError
from rosbase.control.frames import MOST_ANSWER, FrameReader, encode

JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    # A lone half of a pair, which is no text in UTF-8, is one in JSON.
    | st.text(st.characters(exclude_categories=())),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=10,
)
OBJECTS = st.dictionaries(st.text().filter(lambda key: key != "bytes"), JSON)
FRAMES = st.tuples(OBJECTS, st.binary(max_size=40))
NEARLY = st.one_of(
    st.binary(),
    FRAMES.map(lambda frame: encode(*frame)),
    st.sampled_from([b"{", b"}", b"\n", b'"bytes":', b"9", b"-", b"[", b"\\u", b"\xff", b"NaN"]),
)


def read_all(reader: FrameReader, pieces: list[bytes]) -> list[tuple[dict[str, Any], bytes]]:
    """Feeds the pieces; ends at the first fault."""
    found = []
    for piece in pieces:
        reader.feed(piece)
        try:
            while (frame := reader.next()) is not None:
                found.append(frame)
        except ControlError:
            # From now on it says nothing else, and keeps nothing.
            with pytest.raises(ControlError) as caught:
                reader.next()
            assert caught.value.kind == "invalid"
            assert "\n" not in str(caught.value)
            assert reader.held == 0
            return found
    return found


def cut(data: bytes, places: list[int]) -> list[bytes]:
    ends = sorted({0, len(data), *(place % (len(data) + 1) for place in places)})
    return [data[a:b] for a, b in pairwise(ends)]


@given(st.lists(NEARLY, max_size=8))
@example([b"[" * 60_000 + b"\n"])
@example([b'{"id":' + b"9" * 10_000 + b"}\n"])
@example([b'{"a":NaN}\n'])
@example([b'{"bytes":true}\n'])
@example([b'{"bytes":-1}\n'])
@example([b'{"bytes":1e2}\n'])
@example([b'{"bytes":' + b"9" * 4_000 + b"}\n"])
@example([b"\xef\xbb\xbf{}\n"])
@example([b"\n"])
def test_any_bytes_give_frames_or_a_control_error_in_bounded_memory(pieces: list[bytes]) -> None:
    reader = FrameReader(most_line=70_000, most_payload=100)
    read_all(reader, pieces)
    assert reader.held <= 70_100 + max(map(len, pieces), default=0)


@settings(max_examples=50)
@given(st.lists(FRAMES, max_size=3), st.lists(st.integers(0, 10_000), max_size=10))
def test_frames_arrive_as_they_were_written_however_they_are_cut(
    frames: list[tuple[dict[str, Any], bytes]], places: list[int]
) -> None:
    data = b"".join(encode(*frame) for frame in frames)
    found = read_all(FrameReader(), cut(data, places))
    expected = [({**head, "bytes": len(p)} if p else head, p) for head, p in frames]
    assert found == expected


@given(st.binary(max_size=200), st.lists(st.integers(0, 200), max_size=5))
def test_the_cutting_of_bytes_changes_nothing(data: bytes, places: list[int]) -> None:
    whole = read_all(FrameReader(most_line=50, most_payload=20), [data])
    assert read_all(FrameReader(most_line=50, most_payload=20), cut(data, places)) == whole


def test_a_line_is_as_long_as_the_limit_and_no_longer() -> None:
    line = b'{"a":"' + b"x" * 92 + b'"}'
    assert len(line) == 100
    assert len(read_all(FrameReader(most_line=100), [line + b"\n"])) == 1
    assert read_all(FrameReader(most_line=99), [line + b"\n"]) == []


def test_a_line_without_an_end_is_given_up_at_the_limit() -> None:
    reader = FrameReader(most_line=1_000)
    for _ in range(1_000):
        reader.feed(b"x")
        assert reader.next() is None
    reader.feed(b"x")
    with pytest.raises(ControlError, match="more than 1000 bytes"):
        reader.next()
    reader.feed(b"y" * 1_000_000)
    assert reader.held == 0


def test_what_came_before_the_fault_is_read() -> None:
    assert read_all(FrameReader(), [b'{"a":1}\n{"b":2}\nrubbish\n']) == [
        ({"a": 1}, b""),
        ({"b": 2}, b""),
    ]


def test_a_frame_is_one_line_of_ascii() -> None:
    line = encode({"text": "a\nb\u2028\ud800 \x00", "id": 1})
    assert line.count(b"\n") == 1
    assert line.isascii()
    assert json.loads(line) == {"text": "a\nb\u2028\ud800 \x00", "id": 1}


@pytest.mark.parametrize("value", [float("nan"), float("inf"), {1, 2}, b"bytes", object()])
def test_what_is_no_json_is_refused(value: object) -> None:
    with pytest.raises(ControlError, match="JSON"):
        encode({"value": value})


def test_an_answer_that_is_too_long_is_refused() -> None:
    with pytest.raises(ControlError, match="too long"):
        encode({"text": "x" * MOST_ANSWER})
