"""Brokers that misbehave: what each does with a connection, as behaviours of a scripted broker.

Those that flood go on until their connection ends.
"""

import base64
import hashlib
import itertools
import random
import re
import struct
from collections.abc import Callable, Iterable, Iterator

from support.mqtt import (
    CONNACK,
    CONNECT,
    DISCONNECT,
    PINGREQ,
    PINGRESP,
    PUBACK,
    PUBLISH,
    SUBACK,
    SUBSCRIBE,
    UNSUBACK,
    UNSUBSCRIBE,
    Behaviour,
    Peer,
    packet,
)
from support.samples import frame

__all__ = ["KINDS", "Kind", "good"]

TOPIC = b"esp32/imu"
_MIDS = [mid.to_bytes(2, "big") for mid in range(1, 65_536)]
_GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
_HUGE = 256 * 1024 * 1024 - 1


class Wire:
    """A connection as either version of MQTT has it, on TCP or in a WebSocket."""

    def __init__(self, peer: Peer, kind: "Kind") -> None:
        self.peer = peer
        self.is_5 = kind.version == "5"
        self._is_websocket = kind.scheme == "ws"

    def send(self, data: bytes) -> None:
        self.peer.send(ws_frame(data) if self._is_websocket else data)

    def flood(self, parts: Iterable[bytes]) -> None:
        """Sends these, many at a time, for as long as somebody reads."""
        iterator = iter(parts)
        while batch := b"".join(itertools.islice(iterator, 500)):
            self.send(batch)

    def upgrade(self) -> None:
        """Answers the request for a WebSocket, where there is one."""
        if self._is_websocket:
            request = b""
            while not request.endswith(b"\r\n\r\n"):
                request += self.peer.read(1)
            self.peer.send(ws_answer(request))

    def receive(self) -> tuple[int, bytes]:
        """The next packet; a client sends each as a frame of its own."""
        if not self._is_websocket:
            return self.peer.receive()
        while True:
            code, data = ws_read(self.peer)
            if code == 2:
                skipped = 2
                while data[skipped - 1] & 0x80:
                    skipped += 1
                return data[0], data[skipped:]

    def greet(self, more: bytes = b"") -> None:
        """Lets the client in."""
        self.upgrade()
        kind, _ = self.receive()
        assert kind == CONNECT
        properties = bytes([len(more)]) + more if self.is_5 else b""
        self.send(packet(CONNACK, b"\0\0" + properties))

    def serve(self, *, until: int | None = None) -> bytes:
        """Answers what a client asks, up to a packet of that kind; gives its packet id."""
        none = b"\0" if self.is_5 else b""
        while True:
            kind, body = self.receive()
            answers = {
                SUBSCRIBE: packet(SUBACK, body[:2] + none + b"\0"),
                UNSUBSCRIBE: packet(UNSUBACK, body[:2] + none + none),
                PINGREQ: packet(PINGRESP),
            }
            if kind == until:
                return body[:2]
            self.send(answers.get(kind, b""))
            if kind == DISCONNECT:
                raise EOFError

    def subscribed(self) -> None:
        """Lets the client in and lets it read."""
        self.greet()
        mid = self.serve(until=SUBSCRIBE)
        self.send(packet(SUBACK, mid + (b"\0\0" if self.is_5 else b"\0")))

    def publish(
        self,
        payload: bytes,
        *,
        topic: bytes = TOPIC,
        flags: int = 0,
        mid: bytes = b"",
        properties: bytes = b"",
    ) -> bytes:
        """A message of this version."""
        head = len(topic).to_bytes(2, "big") + topic + mid
        if self.is_5:
            head += packet(0, properties)[1:]
        return packet(PUBLISH | flags, head + payload)


class Kind:
    """A way to misbehave."""

    def __init__(
        self,
        act: Callable[[Wire], None],
        *,
        version: str = "3.1.1",
        scheme: str = "tcp",
        qos: int = 0,
    ) -> None:
        self.version, self.scheme, self.qos = version, scheme, qos
        self._act = act

    def misbehave(self, peer: Peer) -> None:
        """What such a broker does with a connection."""
        self._act(Wire(peer, self))


def good(kind: Kind) -> Behaviour:
    """What a good broker does with the same client: it has samples for it."""

    def behave(peer: Peer) -> None:
        wire = Wire(peer, kind)
        wire.subscribed()
        while True:
            wire.send(wire.publish(frame()))
            peer.pause(0.02)

    return behave


# WebSocket, as a server.


def ws_answer(request: bytes) -> bytes:
    (key,) = re.findall(rb"(?i)sec-websocket-key: (\S+)", request)
    accept = base64.b64encode(hashlib.sha1(key + _GUID).digest())
    lines = [
        b"HTTP/1.1 101 Switching Protocols",
        b"Upgrade: websocket",
        b"Connection: Upgrade",
        b"Sec-WebSocket-Accept: " + accept,
        b"Sec-WebSocket-Protocol: mqtt",
    ]
    return b"\r\n".join(lines) + b"\r\n\r\n"


def ws_frame(data: bytes, first: int = 0x82, length: int | None = None) -> bytes:
    """A frame of a server; its length may be a lie."""
    size = len(data) if length is None else length
    if size < 126:
        return bytes([first, size]) + data
    if size < 65_536:
        return struct.pack("!BBH", first, 126, size) + data
    return struct.pack("!BBQ", first, 127, size) + data


def ws_read(peer: Peer) -> tuple[int, bytes]:
    """A frame of a client: its code, and what is in it."""
    first, second = peer.read(2)
    assert second & 0x80, "a client's frames are masked"
    size = second & 0x7F
    if size > 125:
        size = int.from_bytes(peer.read(2 if size == 126 else 8), "big")
    mask, data = peer.read(4), peer.read(size)
    return first & 0x0F, bytes(byte ^ mask[n % 4] for n, byte in enumerate(data))


# What they do.


def floods(make: Callable[[Wire], Iterable[bytes]]) -> Callable[[Wire], None]:
    """Once there is a subscription, sends these for ever."""

    def act(wire: Wire) -> None:
        wire.subscribed()
        wire.flood(itertools.chain.from_iterable(make(wire) for _ in itertools.count()))

    return act


def unreleased(size: int) -> Callable[[Wire], None]:
    payload = frame().ljust(size)
    return floods(lambda wire: (wire.publish(payload, flags=4, mid=mid) for mid in _MIDS))


def answers_to_nothing(kind: int, more: bytes = b"") -> Callable[[Wire], None]:
    return floods(lambda wire: (packet(kind, mid + more) for mid in _MIDS))


def drips(data: Callable[[Wire], Iterable[bytes]], pause_s: float) -> Callable[[Wire], None]:
    """Sends these with a pause after each."""

    def act(wire: Wire) -> None:
        wire.subscribed()
        for part in data(wire):
            wire.send(part)
            wire.peer.pause(pause_s)

    return act


def announces(kind: int, head: bytes) -> Callable[[Wire], None]:
    """Sends packets of 256 MB, as fast as they are read."""
    begin = packet(kind, head)[:1] + b"\xff\xff\xff\x7f" + head

    def parts(wire: Wire) -> Iterator[bytes]:
        yield begin
        block = bytes(65_536)
        left = _HUGE - len(head)
        while left:
            yield block[:left]
            left -= len(block[:left])

    return floods(parts)


def dripped(wire: Wire) -> Iterator[bytes]:
    yield b"\x30\xff\xff\xff\x7f\0\x09" + TOPIC
    while True:
        yield b"x"


def a_byte_at_a_time(wire: Wire) -> Iterator[bytes]:
    message = wire.publish(frame())
    while True:
        for byte in message:
            yield bytes([byte])


def sends_once(data: Callable[[Wire], bytes]) -> Callable[[Wire], None]:
    """Sends this, and is a good broker otherwise, as long as the client stays."""

    def act(wire: Wire) -> None:
        wire.subscribed()
        wire.send(data(wire))
        wire.serve()

    return act


def user_properties(size: int) -> bytes:
    return b"\x26\0\1a\0\1b" * (size // 7)


def topics(wire: Wire) -> Iterator[bytes]:
    """Ones that are none, and a different one each time."""
    for number in range(1000):
        mark = b"%d" % number
        for topic in (
            b"",
            b"lab/+/" + mark,
            b"#",
            b"\xff\xfe" + mark,
            b"lab/\0" + mark,
            b"lab/\x1b[2J" + mark,
            "lab/\u202e".encode() + mark,
            "lab/\x85".encode() + mark,
            mark.ljust(65_535, b"x"),
        ):
            yield wire.publish(b"x", topic=topic)


def before_the_answer(wire: Wire) -> None:
    wire.greet()
    wire.serve(until=SUBSCRIBE)
    wire.flood(wire.publish(frame()) for _ in itertools.count())


def many_codes(wire: Wire) -> None:
    wire.greet()
    mid = wire.serve(until=SUBSCRIBE)
    wire.send(packet(SUBACK, mid + (b"\0" if wire.is_5 else b"") + bytes(60_000)))
    wire.serve()


def another_answer(wire: Wire) -> None:
    wire.greet()
    mid = wire.serve(until=SUBSCRIBE)
    wire.flood(packet(SUBACK, other + b"\0") for other in itertools.cycle(_MIDS) if other != mid)


def no_answer(wire: Wire) -> None:
    wire.greet()
    while True:
        wire.receive()


def greets_without_end(wire: Wire) -> None:
    wire.upgrade()
    wire.receive()
    wire.send(b"\x20\xff\xff\xff\x7f\0\0" + b"\xff\xff\xff\x7f")
    wire.flood(itertools.repeat(user_properties(65_536)))


def greets_at_length(wire: Wire) -> None:
    wire.upgrade()
    wire.receive()
    properties = user_properties(120_000)
    wire.send(packet(CONNACK, b"\0\0" + packet(0, properties)[1:]))
    wire.serve()


_choose = random.Random(13)


def cut_anywhere(wire: Wire) -> None:
    wire.subscribed()
    kinds = _choose.choices([(0, b""), (2, b"\0\7"), (4, b"\0\7")], k=20)
    payloads = [frame().ljust(_choose.randrange(60_000)) for _ in kinds]
    stream = b"".join(
        wire.publish(payload, flags=flags, mid=mid)
        for payload, (flags, mid) in zip(payloads, kinds, strict=True)
    )
    wire.send(stream[: _choose.randrange(len(stream))])


def never_reads(wire: Wire) -> None:
    wire.subscribed()
    wire.peer.shrink()
    wire.flood(wire.publish(b"x", flags=2, mid=mid) for mid in itertools.cycle(_MIDS))


def refers_elsewhere(wire: Wire) -> None:
    """Ends each connection for another reason, in words of its own."""
    wire.subscribed()
    words = f"\x1b[2J\n[INFO] [reader]: all is well {_choose.randrange(10**9)}".encode()
    elsewhere = b"mqtt%d.example" % _choose.randrange(10**9)
    properties = b"\x1f" + struct.pack("!H", len(words)) + words
    properties += b"\x1c" + struct.pack("!H", len(elsewhere)) + elsewhere
    wire.send(packet(DISCONNECT, b"\x9c" + bytes([len(properties)]) + properties))
    wire.receive()


def refuses_in_other_words(wire: Wire) -> None:
    wire.upgrade()
    wire.receive()
    words = b"no %d" % _choose.randrange(10**9)
    properties = b"\x1f" + struct.pack("!H", len(words)) + words
    wire.send(packet(CONNACK, b"\0\x88" + bytes([len(properties)]) + properties))


def says_it_twice(wire: Wire) -> None:
    wire.subscribed()
    wire.flood(itertools.repeat(packet(CONNACK, b"\0\0\0" if wire.is_5 else b"\0\0")))


def ws_begin(wire: Wire) -> None:
    wire.subscribed()


def ws_huge_frame(wire: Wire) -> None:
    """One frame for ever, full of messages."""
    ws_begin(wire)
    wire.peer.send(ws_frame(b"", length=1 << 62))
    block = wire.publish(frame()) * 200
    while True:
        wire.peer.send(block)


def ws_flood(frames: bytes) -> Callable[[Wire], None]:
    def act(wire: Wire) -> None:
        ws_begin(wire)
        while True:
            wire.peer.send(frames)

    return act


def ws_pings_unread(wire: Wire) -> None:
    ws_begin(wire)
    wire.peer.shrink()
    while True:
        wire.peer.send(ws_frame(b"x" * 125, 0x89) * 500)


def ws_endless_headers(wire: Wire) -> None:
    wire.peer.send(b"HTTP/1.1 101 Switching Protocols\r\n")
    while True:
        wire.peer.send(b"X-More: and more\r\n" * 1000)


def ws_header_in_drops(wire: Wire) -> None:
    wire.peer.send(b"HTTP/1.1 101 ")
    while True:
        wire.peer.send(b"x")
        wire.peer.pause(0.01)


def ws_pieces(wire: Wire) -> None:
    """A message in pieces of nothing, for ever."""
    ws_begin(wire)
    wire.peer.send(ws_frame(b"", 0x02))
    while True:
        wire.peer.send(ws_frame(b"", 0x00) * 2000)


KINDS: dict[str, Kind] = {
    "QoS 2 never released, small": Kind(unreleased(300), qos=2),
    "QoS 2 never released, huge": Kind(unreleased(60_000), qos=2),
    "QoS 2 never released, MQTT 5": Kind(unreleased(60_000), qos=2, version="5"),
    "SUBACK to nothing": Kind(answers_to_nothing(SUBACK, b"\0")),
    "SUBACK to nothing, MQTT 5": Kind(answers_to_nothing(SUBACK, b"\0\0"), version="5"),
    "UNSUBACK to nothing": Kind(answers_to_nothing(UNSUBACK)),
    "UNSUBACK to nothing, MQTT 5": Kind(answers_to_nothing(UNSUBACK, b"\0\0"), version="5"),
    "PUBACK to nothing": Kind(answers_to_nothing(PUBACK)),
    "PUBREC to nothing": Kind(answers_to_nothing(0x50)),
    "PUBREL of nothing": Kind(answers_to_nothing(0x62)),
    "PUBCOMP of nothing": Kind(answers_to_nothing(0x70)),
    "PINGRESP flood": Kind(floods(lambda wire: [packet(PINGRESP)] * 500)),
    "PINGREQ flood": Kind(floods(lambda wire: [packet(PINGREQ)] * 500)),
    "AUTH flood": Kind(floods(lambda wire: [packet(0xF0, b"\x18\0")] * 500), version="5"),
    "a message of 256 MB": Kind(announces(PUBLISH, b"\0\x09" + TOPIC)),
    "a SUBACK of 256 MB": Kind(announces(SUBACK, b"\0\1")),
    "256 MB announced and dripped": Kind(drips(dripped, 0.02)),
    "one byte at a time": Kind(drips(a_byte_at_a_time, 0.05)),
    "a length of five bytes": Kind(sends_once(lambda wire: b"\x30\xff\xff\xff\xff\x01")),
    "QoS 3": Kind(sends_once(lambda wire: wire.publish(b"x", flags=6, mid=b"\0\1"))),
    "kind 0": Kind(sends_once(lambda wire: packet(0x00, b"abc"))),
    "kind 15": Kind(sends_once(lambda wire: packet(0xF0, b"abc"))),
    "reserved flags": Kind(sends_once(lambda wire: packet(0xD1))),
    "packets cut anywhere": Kind(cut_anywhere),
    "let in twice": Kind(says_it_twice),
    "let in twice, MQTT 5": Kind(says_it_twice, version="5"),
    "let in without an end": Kind(greets_without_end, version="5"),
    "let in at length": Kind(greets_at_length, version="5"),
    "messages before SUBACK": Kind(before_the_answer),
    "SUBACK with 60,000 codes": Kind(many_codes),
    "SUBACK with 60,000 codes, MQTT 5": Kind(many_codes, version="5"),
    "SUBACK for others": Kind(another_answer),
    "no SUBACK": Kind(no_answer),
    "thousands of properties": Kind(
        floods(lambda w: [w.publish(frame(), properties=user_properties(120_000))] * 20),
        version="5",
    ),
    "topic aliases": Kind(
        floods(
            lambda wire: [
                wire.publish(frame(), topic=topic, properties=b"\x23" + alias)
                for topic in (b"", TOPIC)
                for alias in (b"\0\0", b"\0\1", b"\xff\xff")
            ]
        ),
        version="5",
    ),
    "topics that are none": Kind(floods(topics)),
    "topics that are none, MQTT 5": Kind(floods(topics), version="5"),
    "sent again and again": Kind(
        floods(lambda wire: [wire.publish(frame(), flags=0x0A, mid=mid) for mid in _MIDS]), qos=1
    ),
    "never reads": Kind(never_reads, qos=1),
    "refers elsewhere": Kind(refers_elsewhere, version="5"),
    "refuses in other words": Kind(refuses_in_other_words, version="5"),
    "WebSocket, a frame without end": Kind(ws_huge_frame, scheme="ws"),
    "WebSocket, masked": Kind(ws_flood(b"\x82\x85abcd12345"), scheme="ws"),
    "WebSocket, pings": Kind(ws_flood(ws_frame(b"x" * 125, 0x89) * 500), scheme="ws"),
    "WebSocket, pings unread": Kind(ws_pings_unread, scheme="ws"),
    "WebSocket, text": Kind(ws_flood(ws_frame(b"hello", 0x81)), scheme="ws"),
    "WebSocket, pieces of nothing": Kind(ws_pieces, scheme="ws"),
    "WebSocket, headers without end": Kind(ws_endless_headers, scheme="ws"),
    "WebSocket, headers in drops": Kind(ws_header_in_drops, scheme="ws"),
    "WebSocket, QoS 2 never released": Kind(unreleased(60_000), qos=2, scheme="ws"),
}
"""Each with what the reader must be told to meet it."""
