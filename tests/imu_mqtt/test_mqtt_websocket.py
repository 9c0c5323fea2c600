"""The WebSocket below MQTT: its frames in any pieces, and what ends it."""

import base64
import hashlib
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from imu_mqtt.websocket import WebSocket, WebSocketError
from rosbase.testing.strategies import chunkings
from support.misbehaviour import ws_answer, ws_frame

PING, PONG, CLOSE = 0x89, 0x8A, 0x88


def opened() -> WebSocket:
    websocket = WebSocket("broker:80", "/mqtt", is_secure=False)
    assert websocket.take_answer(ws_answer(websocket.request)) == b""
    return websocket


def fed(websocket: WebSocket, chunks: list[bytes]) -> bytes:
    return b"".join(bytes(piece) for chunk in chunks for piece in websocket.feed(memoryview(chunk)))


def unmasked(frame: bytes) -> tuple[int, bytes]:
    """A short frame of a client: its first byte, and what is in it."""
    assert frame[1] & 0x80
    mask, data = frame[2:6], frame[6:]
    assert len(data) == frame[1] & 0x7F
    return frame[0], bytes(byte ^ mask[n % 4] for n, byte in enumerate(data))


@given(st.data(), st.lists(st.binary(max_size=300), max_size=6))
def test_what_is_in_frames_comes_out_for_every_chunking(
    data: st.DataObject, parts: list[bytes]
) -> None:
    frames = []
    for part in parts:
        if data.draw(st.booleans()):
            half = len(part) // 2
            # A message in two pieces, and a ping between them.
            frames += [
                ws_frame(part[:half], 0x02),
                ws_frame(b"?", PING),
                ws_frame(part[half:], 0x80),
            ]
        else:
            frames.append(ws_frame(part))
    chunks = data.draw(chunkings(b"".join(frames)))
    assert fed(opened(), chunks) == b"".join(parts)


@pytest.mark.parametrize("size", [0, 1, 125, 126, 65_535, 65_536, 200_000])
def test_a_frame_of_any_length_is_read(size: int) -> None:
    data = bytes(range(256)) * (size // 256 + 1)
    assert fed(opened(), [ws_frame(data[:size])]) == data[:size]


def test_a_frame_without_an_end_is_passed_on_as_it_comes() -> None:
    websocket = opened()
    assert fed(websocket, [ws_frame(b"begin", length=(1 << 63) - 1)]) == b"begin"
    assert fed(websocket, [b"more"] * 1_000) == b"more" * 1_000


def test_only_the_last_ping_is_answered_and_that_masked() -> None:
    websocket = opened()
    fed(websocket, [ws_frame(b"first", PING) * 1_000 + ws_frame(b"last", PING)])
    assert unmasked(websocket.answers()) == (PONG, b"last")
    assert websocket.answers() == b""


def test_a_farewell_is_answered_and_ends_it() -> None:
    websocket = opened()
    assert fed(websocket, [ws_frame(b"x") + ws_frame(b"\x03\xe8", CLOSE) + ws_frame(b"y")]) == b"x"
    assert unmasked(websocket.answers()) == (CLOSE, b"\x03\xe8")
    assert websocket.has_ended


@given(st.binary(max_size=70_000))
def test_what_is_sent_is_masked_and_can_be_read(data: bytes) -> None:
    frame = WebSocket.frame(data)
    begin = 6 if len(data) < 126 else 8 if len(data) < 65_536 else 14
    mask, masked = frame[begin - 4 : begin], frame[begin:]
    assert frame[1] & 0x80
    assert len(masked) == len(data)
    assert bytes(byte ^ mask[n % 4] for n, byte in enumerate(masked[:500])) == data[:500]


REFUSED = {
    "masked": b"\x82\x85abcd12345",
    "text": ws_frame(b"x", 0x81),
    "reserved bits": ws_frame(b"x", 0xC2),
    "an unknown code": ws_frame(b"x", 0x83),
    "a long ping": ws_frame(bytes(126), PING),
    "a ping in pieces": ws_frame(b"x", 0x09),
    "a piece without a beginning": ws_frame(b"x", 0x80),
    "two beginnings": ws_frame(b"x", 0x02) * 2,
}


@pytest.mark.parametrize("data", REFUSED.values(), ids=REFUSED)
def test_what_a_server_must_not_send_is_refused(data: bytes) -> None:
    with pytest.raises(WebSocketError, match="WebSocket"):
        fed(opened(), [data])


@given(st.data(), st.binary(max_size=50))
def test_the_answer_is_read_in_any_pieces_and_what_stands_behind_it_is_kept(
    data: st.DataObject, behind: bytes
) -> None:
    websocket = WebSocket("broker:80", "/mqtt", is_secure=True)
    pieces = data.draw(chunkings(ws_answer(websocket.request) + behind))
    early = None
    rest = b""
    for piece in pieces:
        if early is None:
            early = websocket.take_answer(piece)
        else:
            rest += piece
    assert (early or b"") + rest == behind


def test_the_answer_may_be_written_as_http_allows() -> None:
    websocket = WebSocket("broker:80", "/mqtt", is_secure=False)
    (key,) = re.findall(rb"Sec-WebSocket-Key: (\S+)", websocket.request)
    accept = base64.b64encode(hashlib.sha1(key + b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest())
    lines = [b"HTTP/1.1 101 OK", b"upgrade:WebSocket", b"SEC-WEBSOCKET-ACCEPT:" + accept, b"", b""]
    assert websocket.take_answer(b"\r\n".join(lines)) == b""


ANSWERS = {
    "not found": (b"HTTP/1.1 404 Not \x1b[2J\x07Found\r\n\r\n", r"404 Not \\x1b\[2J\\x07Found"),
    "no HTTP": (b"\x15\x03\x01\r\n\r\n", r"^\\x15\\x03\\x01$"),
    "nothing": (b"\r\n\r\n", "an empty answer"),
    "another key": (b"HTTP/1.1 101 OK\r\nSec-WebSocket-Accept: x\r\n\r\n", "another request"),
    "no end": (b"HTTP/1.1 101 OK\r\n" + b"X: y\r\n" * 2_000, "does not end"),
    "a line without end": (b"x" * 9_000, "does not end"),
}


@pytest.mark.parametrize(("data", "why"), ANSWERS.values(), ids=ANSWERS)
def test_a_server_that_speaks_something_else_is_named_in_one_line(data: bytes, why: str) -> None:
    websocket = WebSocket("broker:80", "/mqtt", is_secure=False)
    with pytest.raises(WebSocketError, match=why) as caught:
        websocket.take_answer(data)
    assert str(caught.value).isprintable()
