"""The packets of a broker: the same for every chunking, refused as soon as they are none."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from imu_mqtt.packets import (
    CONNACK,
    MOST_PACKET_BYTES,
    PINGRESP,
    PUBREL,
    SUBACK,
    Control,
    MalformedError,
    Message,
    PacketReader,
)
from rosbase.testing.resources import memory_growth
from rosbase.testing.strategies import chunkings
from support.mqtt import packet, publish_packet

LET_IN = {False: packet(CONNACK, b"\0\0"), True: packet(CONNACK, b"\0\0\0")}


def read(chunks: list[bytes], *, is_5: bool = False) -> list[Message | Control]:
    """What comes out behind the broker's greeting."""
    reader = PacketReader(is_5=is_5)
    found: list[Message | Control] = []
    for chunk in [LET_IN[is_5], *chunks]:
        rest = chunk
        while rest:
            room = reader.room()
            piece, rest = rest[: len(room)], rest[len(room) :]
            room[: len(piece)] = piece
            reader.add(len(piece))
            found += iter(reader.take, None)
    return found[1:]


def message(topic: str = "a/b", payload: bytes = b"x", **changes: Any) -> Message:
    fields: dict[str, Any] = {
        "qos": 0, "packet_id": 0, "retain": False, "dup": False, "size": len(payload), "fault": "",
    }  # fmt: skip
    return Message(topic=topic, payload=payload, **(fields | changes))


topic_texts = st.text(
    st.characters(codec="utf-8", exclude_categories=["Cc"], exclude_characters="+#"),
    min_size=1,
    max_size=30,
)


@st.composite
def sent(draw: st.DrawFn, *, is_5: bool) -> tuple[bytes, Message]:
    """A good message: its bytes, and what is to come of them."""
    topic, payload = draw(topic_texts), draw(st.binary(max_size=300))
    qos, retain = draw(st.integers(0, 2)), draw(st.booleans())
    dup = draw(st.booleans()) if qos else False
    mid = draw(st.integers(1, 65_535)) if qos else 0
    raw = topic.encode()
    body = len(raw).to_bytes(2, "big") + raw + (mid.to_bytes(2, "big") if qos else b"")
    if is_5:
        body += packet(0, draw(st.binary(max_size=200)))[1:]
    data = packet(0x30 | dup << 3 | qos << 1 | retain, body + payload)
    return data, message(topic, payload, qos=qos, packet_id=mid, retain=retain, dup=dup)


@given(st.data(), st.booleans())
def test_good_messages_come_out_whole_and_in_order_for_every_chunking(
    data: st.DataObject, is_5: bool
) -> None:
    packets = data.draw(st.lists(sent(is_5=is_5), max_size=8))
    stream = b"".join(raw for raw, _ in packets)
    assert read(data.draw(chunkings(stream)), is_5=is_5) == [wanted for _, wanted in packets]


@given(st.data(), st.booleans())
def test_of_any_bytes_comes_the_same_for_every_chunking_or_one_refusal(
    data: st.DataObject, is_5: bool
) -> None:
    good = st.sampled_from(
        [
            publish_packet(b"a", b"x"),
            packet(PINGRESP),
            packet(SUBACK, b"\0\1\0"),
            packet(PUBREL, b"\0\1"),
        ]
    )
    stream = b"".join(data.draw(st.lists(good | st.binary(max_size=12), max_size=8)))

    def outcome(chunks: list[bytes]) -> tuple[list[Message | Control], str]:
        reader = PacketReader(is_5=is_5)
        found: list[Message | Control] = []
        for chunk in [LET_IN[is_5], *chunks]:
            reader.room()[: len(chunk)] = chunk
            reader.add(len(chunk))
            try:
                found += iter(reader.take, None)
            except MalformedError as error:
                with pytest.raises(MalformedError, match=r"^a "):
                    reader.take()
                return found, str(error)
        return found, ""

    assert outcome(data.draw(chunkings(stream))) == outcome([stream])


REFUSED = {
    "kind 0": packet(0x00),
    "CONNECT": packet(0x10, b"x"),
    "let in twice": packet(CONNACK, b"\0\0"),
    "QoS 3": packet(0x36, b"\0\1a\0\1"),
    "a packet id of 0": packet(0x32, b"\0\1a\0\0"),
    "no topic": packet(0x30),
    "half a topic": packet(0x30, b"\0\x09abc"),
    "half a packet id": packet(0x32, b"\0\1a\0"),
    "PUBREC": packet(0x50, b"\0\1"),
    "PUBREL with other flags": packet(0x60, b"\0\1"),
    "PUBCOMP": packet(0x70, b"\0\1"),
    "SUBSCRIBE": packet(0x82, b"\0\1\0\1a\0"),
    "SUBACK without a code": packet(SUBACK, b"\0\1"),
    "SUBACK with two codes": packet(SUBACK, b"\0\1\0\0"),
    "UNSUBACK at length": packet(0xB0, b"\0\1\0"),
    "PINGREQ": packet(0xC0),
    "PINGRESP with something in it": packet(PINGRESP, b"x"),
    "PINGRESP with flags": packet(0xD1),
    "DISCONNECT": packet(0xE0),
    "AUTH": packet(0xF0, b"\0\0"),
    "a length of five bytes": b"\x30\xff\xff\xff\xff\x01",
    "a SUBACK of 256 MB, begun": b"\x90\xff\xff\xff\x7f",
}


@pytest.mark.parametrize("data", REFUSED.values(), ids=REFUSED)
def test_what_no_broker_sends_is_refused(data: bytes) -> None:
    with pytest.raises(MalformedError):
        read([data])


REFUSED_5 = {
    "AUTH": packet(0xF0, b"\x18\0"),
    "properties that are cut": packet(0x30, b"\0\1a\x7f"),
    "a length of properties without an end": packet(0x30, b"\0\1a\xff\xff\xff\xff"),
    "no properties": packet(0x30, b"\0\1a"),
    "a SUBACK of 60 kB": packet(SUBACK, bytes(60_000)),
    "a DISCONNECT of 60 kB": packet(0xE0, bytes(60_000)),
}


@pytest.mark.parametrize("data", REFUSED_5.values(), ids=REFUSED_5)
def test_what_no_broker_sends_is_refused_in_mqtt_5(data: bytes) -> None:
    with pytest.raises(MalformedError):
        read([data], is_5=True)


@pytest.mark.parametrize("first", [b"HTTP/1.1 400", publish_packet(b"a", b"x"), packet(PINGRESP)])
def test_the_first_packet_is_the_answer_to_our_greeting(first: bytes) -> None:
    reader = PacketReader(is_5=False)
    reader.room()[: len(first)] = first
    reader.add(len(first))
    with pytest.raises(MalformedError, match="before CONNACK"):
        reader.take()


BAD_TOPICS = [
    b"", b"+", b"a/#", b"\xff", b"\xed\xa0\x80", b"a\0b", b"lab/\x1b[2J", b"a\nb", b"\x7f",
    "\x85".encode(), "\x9b2J".encode(),
]  # fmt: skip


@pytest.mark.parametrize("topic", BAD_TOPICS)
@pytest.mark.parametrize("is_5", [False, True])
def test_a_topic_that_mqtt_does_not_allow_is_a_fault_and_the_stream_goes_on(
    topic: bytes, is_5: bool
) -> None:
    none = b"\0" if is_5 else b""
    bad = packet(0x30, len(topic).to_bytes(2, "big") + topic + none + b"x")
    good = packet(0x30, b"\0\1a" + none + b"y")
    first, *others = read([good, bad, bad, good], is_5=is_5)
    assert [m.fault for m in others if isinstance(m, Message)] == ["bad_topic", "bad_topic", ""]
    assert first == others[-1] == message("a", b"y")


def test_a_topic_in_any_letters_is_one() -> None:
    for topic in ("labor/größe", "研究/慣性", "lab/\u202eumi", "$SYS/x", "/", " "):
        assert read([publish_packet(topic.encode(), b"x")]) == [message(topic)]


@given(st.data(), st.integers(0, 2))
def test_a_message_that_is_too_long_is_skipped_and_counted(data: st.DataObject, qos: int) -> None:
    size = MOST_PACKET_BYTES + data.draw(st.integers(1, 300_000))
    head = b"\0\3a/b" + (b"\0\7" if qos else b"")
    stream = packet(0x30 | qos << 1, head + bytes(size)) + publish_packet(b"a/b", b"x")
    mid = 7 if qos else 0
    long = message(payload=b"", qos=qos, packet_id=mid, size=size, fault="overlong")
    step = data.draw(st.integers(1_000, 200_000))
    chunks = [stream[begin : begin + step] for begin in range(0, len(stream), step)]
    assert read(chunks) == [long, message()]


def test_the_longest_message_that_is_kept_comes_out_whole() -> None:
    payload = bytes(MOST_PACKET_BYTES - 5)
    assert read([publish_packet(b"a/b", payload)] * 3) == [message(payload=payload)] * 3


def test_memory_stays_flat_whatever_is_announced() -> None:
    begin, more = b"\x30\xff\xff\xff\x7f\xff\xff".ljust(65_536, b"x"), bytes(65_536)
    reader = PacketReader(is_5=False)
    with memory_growth() as growth:
        for chunk in (LET_IN[False], begin, *[more] * 2_000):
            reader.room()[: len(chunk)] = chunk
            reader.add(len(chunk))
            reader.take()
        # The topic of the message is in it, as bytes and as text, and as long as a topic can be.
        assert growth() < 2 * MOST_PACKET_BYTES
