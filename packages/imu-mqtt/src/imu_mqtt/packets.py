"""The packets that a broker sends: bytes in, packets out. No I/O, and bounded memory.

The broker is not trusted: lengths, flags and the order of packets are checked here, before any
other code reads them. Messages are decoded. The other packets are rare, and are handed on whole.
None of them is longer than a few kilobytes.
"""

from typing import NamedTuple

__all__ = [
    "CONNACK",
    "DISCONNECT",
    "MOST_PACKET_BYTES",
    "PINGRESP",
    "PUBACK",
    "PUBREL",
    "SUBACK",
    "UNSUBACK",
    "Control",
    "MalformedError",
    "Message",
    "PacketReader",
]

MOST_PACKET_BYTES = 2 * 65_536 + 1_024
"""Maximum length of a packet: twice the longest payload, and its topic.

Longer ones are skipped and counted.
"""

CONNACK, PUBLISH, PUBACK, PUBREL, SUBACK = 0x20, 0x30, 0x40, 0x62, 0x90
UNSUBACK, PINGRESP, DISCONNECT = 0xB0, 0xD0, 0xE0

_READ_BYTES = 65_536
# The fixed header of a packet: its kind, and a length of up to four bytes.
_HEADER_BYTES = 5
# The longest control packet with properties. More than that costs paho seconds to decode.
_MOST_CONTROL_BYTES = 8_192

# The least and the greatest length of each packet but PUBLISH. We subscribe to one topic at a time.
_LENGTHS = {
    CONNACK: (2, 2),
    PUBACK: (2, 2),
    PUBREL: (2, 2),
    SUBACK: (3, 3),
    UNSUBACK: (2, 2),
    PINGRESP: (0, 0),
}
_LENGTHS_5 = {
    CONNACK: (2, _MOST_CONTROL_BYTES),
    PUBACK: (2, _MOST_CONTROL_BYTES),
    PUBREL: (2, _MOST_CONTROL_BYTES),
    SUBACK: (4, _MOST_CONTROL_BYTES),
    UNSUBACK: (4, _MOST_CONTROL_BYTES),
    PINGRESP: (0, 0),
    DISCONNECT: (0, _MOST_CONTROL_BYTES),
}
_HAVE_ID = frozenset({PUBACK, PUBREL, SUBACK, UNSUBACK})


class MalformedError(Exception):
    """The broker sends data that is not MQTT, or not at that moment. The stream ends here."""


class Message(NamedTuple):
    """A published message."""

    topic: str
    """Topic, with escapes for bytes that are not UTF-8."""
    payload: bytes
    """Payload; empty if the message was too long to be kept."""
    qos: int
    packet_id: int
    retain: bool
    dup: bool
    """Whether the broker sends it again, as it says."""
    size: int
    """Length of the payload in bytes; if it was not kept, with the properties before it."""
    fault: str
    """Reason why it cannot be a frame, as a word to count by: `overlong`, `bad_topic`, or empty."""


class Control(NamedTuple):
    """Any other packet."""

    kind: int
    packet_id: int
    """Packet id; 0 if it has none."""
    data: bytes
    """Whole packet."""


class PacketReader:
    """Splits a stream into packets.

    Write arriving data into `room`, give its length to `add`, and call `take` until it has no
    more packets.
    """

    def __init__(self, *, is_5: bool) -> None:
        """Begin a connection.

        Args:
            is_5: Whether the protocol is MQTT 5, not 3.1.1.
        """
        self._is_5 = is_5
        self._lengths = _LENGTHS_5 if is_5 else _LENGTHS
        # One buffer and exact copies keep the memory of the process flat.
        self._buffer = bytearray(_HEADER_BYTES + MOST_PACKET_BYTES + _READ_BYTES)
        self._view = memoryview(self._buffer)
        self._start = self._end = 0
        self._is_greeted = False
        self._skipped: Message | None = None
        self._skip_bytes = 0
        # Of the message before: it is nearly always the same.
        self._raw_topic, self._topic, self._topic_fault = b"", "", "bad_topic"

    def room(self) -> memoryview:
        """Return the buffer for the next bytes."""
        if self._start == self._end:
            self._start = self._end = 0
        elif len(self._buffer) - self._end < _READ_BYTES:
            left = self._end - self._start
            self._view[:left] = self._view[self._start : self._end]
            self._start, self._end = 0, left
        return self._view[self._end : self._end + _READ_BYTES]

    def add(self, count: int) -> None:
        """Add the bytes that were written into `room`."""
        self._end += count

    def take(self) -> Message | Control | None:
        """Return the next packet; None if it has not arrived yet.

        Raises:
            MalformedError: The data is not MQTT. Every further call raises it again.
        """
        if self._skipped is not None:
            return self._skip()
        buffer, start, end = self._buffer, self._start, self._end
        if end - start < 2:
            return None
        kind, length, body = buffer[start], buffer[start + 1], start + 2
        if length > 127:
            length, body = self._long_length(start)
            if not body:
                return None
        stop = body + length
        is_message = kind & 0xF0 == PUBLISH
        if not (is_message and self._is_greeted):
            self._check(kind, length)
        if is_message and length > MOST_PACKET_BYTES:
            return self._begin_skipping(kind, body, stop)
        if stop > end:
            return None
        packet = self._message(kind, body, stop) if is_message else self._control(kind, body, stop)
        self._start = stop
        return packet

    def _long_length(self, start: int) -> tuple[int, int]:
        """Return the length of a packet, and the start of its body; 0 if that is not known yet."""
        length = 0
        for number in range(4):
            place = start + 1 + number
            if place >= self._end:
                return 0, 0
            byte = self._buffer[place]
            length |= (byte & 0x7F) << 7 * number
            if byte < 128:
                return length, place + 1
        raise MalformedError("a packet without a length")

    def _check(self, kind: int, length: int) -> None:
        """Refuse packets that no broker sends, or not now, as soon as they begin."""
        if kind == CONNACK and self._is_greeted:
            raise MalformedError("a second CONNACK")
        if kind != CONNACK and not self._is_greeted:
            raise MalformedError(f"a packet 0x{kind:02x} before CONNACK")
        least, most = self._lengths.get(kind, (1, 0))
        if least > most:
            raise MalformedError(f"a packet 0x{kind:02x}, which no broker may send")
        if not least <= length <= most:
            raise MalformedError(f"a packet 0x{kind:02x} of {length} bytes")

    def _control(self, kind: int, body: int, stop: int) -> Control:
        self._is_greeted = True
        buffer = self._buffer
        packet_id = buffer[body] << 8 | buffer[body + 1] if kind in _HAVE_ID else 0
        return Control(kind, packet_id, bytes(self._view[self._start : stop]))

    def _message(self, kind: int, body: int, stop: int) -> Message:
        after, packet_id = self._read_header(kind, body, stop)
        if self._is_5:
            after = self._after_properties(after, stop)
        payload = bytes(self._view[after:stop])
        return self._made(kind, packet_id, payload, stop - after, self._topic_fault)

    def _made(self, kind: int, packet_id: int, payload: bytes, size: int, fault: str) -> Message:
        qos, retain, dup = kind >> 1 & 3, bool(kind & 1), bool(kind & 8)
        return Message(self._topic, payload, qos, packet_id, retain, dup, size, fault)

    def _read_header(self, kind: int, body: int, stop: int) -> tuple[int, int]:
        """Note the topic; return where it and the packet id end, and the id."""
        buffer = self._buffer
        begin = body + 2
        after = begin + (buffer[body] << 8 | buffer[body + 1])
        packet_id = 0
        qos = kind & 6
        if qos:
            after += 2
        if begin > stop or after > stop:
            raise MalformedError("a message that is shorter than its topic")
        topic = bytes(self._view[begin : after - 2 if qos else after])
        if topic != self._raw_topic:
            self._note_topic(topic)
        if qos:
            packet_id = buffer[after - 2] << 8 | buffer[after - 1]
            if qos == 6 or not packet_id:
                raise MalformedError("a message with an invalid quality of service")
        return after, packet_id

    def _note_topic(self, raw: bytes) -> None:
        """Decode a topic, and return whether MQTT allows it."""
        topic = raw.decode(errors="backslashreplace")
        is_valid = bool(raw) and "+" not in topic and "#" not in topic and _is_text(raw, topic)
        self._raw_topic, self._topic = raw, topic
        self._topic_fault = "" if is_valid else "bad_topic"

    def _after_properties(self, after: int, stop: int) -> int:
        """Return where the properties of a message end; they are ignored."""
        length = 0
        for number in range(4):
            if after + number >= stop:
                break
            byte = self._buffer[after + number]
            length |= (byte & 0x7F) << 7 * number
            if byte < 128:
                end = after + number + 1 + length
                if end > stop:
                    break
                return end
        raise MalformedError("a message that is shorter than its properties")

    def _begin_skipping(self, kind: int, body: int, stop: int) -> Message | None:
        """Keep the head of a message that is too long, and discard the rest as it comes."""
        # A topic, the two lengths around it, and a packet id: less than what is kept for a packet.
        head = body + 2 + (self._buffer[body] << 8 | self._buffer[body + 1]) + 2
        if self._end < body + 2 or self._end < head:
            return None
        after, packet_id = self._read_header(kind, body, stop)
        fault = self._topic_fault or "overlong"
        self._skipped = self._made(kind, packet_id, b"", stop - after, fault)
        self._skip_bytes = stop - self._start
        return self._skip()

    def _skip(self) -> Message | None:
        """Discard arrived data of a long message; return the message when that was all of it."""
        count = min(self._skip_bytes, self._end - self._start)
        self._skip_bytes -= count
        self._start += count
        if self._skip_bytes:
            return None
        message, self._skipped = self._skipped, None
        return message


def _is_text(raw: bytes, topic: str) -> bool:
    """Return whether it is UTF-8 without control characters, which MQTT advises against."""
    try:
        raw.decode()
    except UnicodeDecodeError:
        return False
    return not any(ch < " " or "\x7f" <= ch <= "\x9f" for ch in topic)
