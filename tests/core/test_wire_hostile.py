"""Bytes that are cut, garbled or made to do harm are a WireError, in bounded memory."""

import random
import struct
import tracemalloc
from dataclasses import dataclass
from typing import Annotated, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.errors import WireError
from rosbase.messages import DiagnosticArray, Header, Image, JointState, PointCloud2, String
from rosbase.messages.fields import AtMost, Float32, WString, message
from rosbase.wire import deserialize, serialize
from rosbase.wire.description import describe
from support.wire_messages import CLASSES, Rolled, made, name_of

# A message of a hundred bytes becomes objects of at most some kilobytes.
MOST_BYTES = 200_000


@message("my_msgs/msg/Wide")
@dataclass(frozen=True)
class Wide:
    label: WString = ""
    labels: tuple[WString, ...] = ()
    gains: Annotated[tuple[Float32, ...], AtMost(4)] = ()


READABLE = [*CLASSES, Wide]


def read_or_refuse(data: bytes, cls: type) -> bool:
    """Whether a message could be read; any error but a WireError in one line fails."""
    try:
        deserialize(data, cls)
    except WireError as error:
        text = str(error)
    else:
        return True
    assert text.startswith(f"{name_of(cls)}: ")
    assert "\n" not in text
    assert len(text) < 300
    return False


@pytest.mark.parametrize("cls", READABLE, ids=name_of)
def test_a_message_that_is_cut_short_is_refused_wherever_it_is_cut(cls: type) -> None:
    data = serialize(made(describe(cls), Rolled(21)))
    for end in range(len(data)):
        assert not read_or_refuse(data[:end], cls), end
    assert read_or_refuse(data, cls)


@pytest.mark.parametrize("cls", READABLE, ids=name_of)
def test_garbled_bytes_are_read_or_refused_in_bounded_memory(cls: type) -> None:
    dice = random.Random(22)
    data = serialize(made(describe(cls), Rolled(23)))
    # Readers for both byte orders are compiled.
    for order in (b"\0\1", b"\0\0"):
        read_or_refuse(order + data[2:], cls)
    tracemalloc.start()
    try:
        for _ in range(100):
            garbled = bytearray(data)
            for _ in range(dice.randint(1, 4)):
                index = dice.randrange(len(data))
                garbled[index] = dice.choice((0, 1, 0x7F, 0x80, 0xFF, dice.randrange(256)))
            if len(data) > 12:
                # Lengths have four bytes.
                index = dice.randrange(4, len(data) - 4) & ~3
                garbled[index : index + 4] = struct.pack("<I", dice.choice((2**31, 2**32 - 1, 99)))
            read_or_refuse(bytes(garbled), cls)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < MOST_BYTES + 100 * len(data)


@given(st.sampled_from(READABLE), st.binary(max_size=200), st.sampled_from([b"\0\0", b"\0\1"]))
def test_random_bytes_are_read_or_refused(cls: type, noise: bytes, order: bytes) -> None:
    read_or_refuse(noise, cls)
    read_or_refuse(order + b"\0\0" + noise, cls)


def with_header(*lengths: int) -> bytes:
    """A header without a frame, then these lengths."""
    empty = serialize(Header())
    padded = empty + bytes(-len(empty) % 4)
    return padded + b"".join(struct.pack("<I", length) for length in lengths)


@pytest.mark.parametrize("count", [2**31 - 1, 2**31, 2**32 - 1, 10**6])
@pytest.mark.parametrize(
    ("cls", "data"),
    [
        (String, b"\0\1\0\0"),
        (JointState, with_header()),
        (JointState, with_header(0)),
        (DiagnosticArray, with_header()),
        (Image, with_header(1, 1) + struct.pack("<I", 5) + b"rgb8\0" + bytes(7)),
        (PointCloud2, with_header(1, 1)),
        (Wide, b"\0\1\0\0"),
        (Wide, b"\0\1\0\0" + bytes(4)),
        (Wide, b"\0\1\0\0" + bytes(8)),
    ],
)
def test_a_length_that_no_message_can_have_allocates_nothing(
    cls: type, data: bytes, count: int
) -> None:
    hostile = data + struct.pack("<I", count) + bytes(1000)
    with pytest.raises(WireError):
        deserialize(hostile, cls)
    tracemalloc.start()
    try:
        with pytest.raises(WireError):
            deserialize(hostile, cls)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < MOST_BYTES


@pytest.mark.parametrize("start", [b"", b"\0\2\0\0", b"\0\3\0\0", b"\xff\xff\0\0", b"abcd"])
def test_bytes_that_do_not_begin_as_cdr_does_are_refused(start: bytes) -> None:
    with pytest.raises(WireError, match=r"^std_msgs/msg/String: the bytes do not begin as CDR "):
        deserialize(start + b"\1\0\0\0\0", String)


def test_texts_without_their_end_or_in_another_encoding_are_refused() -> None:
    good = serialize(String("text"))
    for bad in (good[:-1] + b"x", good.replace(b"text", b"t\xffxt")):
        with pytest.raises(WireError, match=r"^std_msgs/msg/String: "):
            deserialize(bad, String)


def test_a_wide_text_with_half_a_character_is_refused_and_a_whole_one_is_read() -> None:
    def wide(*units: int) -> bytes:
        return struct.pack(f"<4xI{len(units)}I8x", len(units), *units).replace(
            b"\0\0\0\0", b"\0\1\0\0", 1
        )

    assert deserialize(wide(0xD83E, 0xDDED), Wide).label == "🧭"
    assert deserialize(wide(0x1F9ED), Wide).label == "🧭"
    for units in ((0xD83E,), (0xDDED, 0xD83E), (0x110000,), (0xFFFFFFFF,)):
        with pytest.raises(WireError):
            deserialize(wide(*units), Wide)


def test_more_elements_than_a_bounded_sequence_has_are_refused() -> None:
    data: Any = struct.pack("<4s3I5f", b"\0\1\0\0", 0, 0, 5, *range(5))
    with pytest.raises(WireError, match=r"^my_msgs/msg/Wide: 5 elements are announced"):
        deserialize(data, Wide)


@message("my_msgs/msg/Bounded")
@dataclass(frozen=True)
class Bounded:
    text: Annotated[str, AtMost(3)] = ""
    texts: tuple[Annotated[str, AtMost(3)], ...] = ()
    wide: Annotated[WString, AtMost(3)] = ""
    wides: tuple[Annotated[WString, AtMost(3)], ...] = ()


@message("my_msgs/msg/Bounded")
@dataclass(frozen=True)
class Unbounded:
    text: str = ""
    texts: tuple[str, ...] = ()
    wide: WString = ""
    wides: tuple[WString, ...] = ()


@given(
    field=st.sampled_from(["text", "texts", "wide", "wides"]),
    text=st.text(st.sampled_from("aä🧭"), max_size=5),
)
def test_a_text_is_read_if_and_only_if_it_can_be_written(field: str, text: str) -> None:
    value: Any = (text,) if field.endswith("s") else text
    data = serialize(Unbounded(**{field: value}))
    count = len(text.encode("utf-16-le")) // 2 if "wide" in field else len(text.encode())
    if count <= 3:
        assert serialize(deserialize(data, Bounded)) == data
    else:
        unit = "UTF-16 units" if "wide" in field else "bytes"
        reason = f"^my_msgs/msg/Bounded: a text has {count} {unit}, which is more than 3$"
        with pytest.raises(WireError, match=reason):
            deserialize(data, Bounded)


@pytest.mark.parametrize("field", ["text", "texts", "wide", "wides"])
def test_a_nul_within_a_text_is_refused(field: str) -> None:
    value: Any = ("axb",) if field.endswith("s") else "axb"
    data = serialize(Unbounded(**{field: value})).replace(b"x", b"\0")
    with pytest.raises(WireError, match=r"^my_msgs/msg/Bounded: a text has a NUL within$"):
        deserialize(data, Unbounded)
