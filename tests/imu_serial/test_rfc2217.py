"""`rfc2217://`: the settings and the lines of a port, at pyserial's own server on loopback."""

import socket
import threading
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from imu_serial.rfc2217 import Rfc2217Client
from rosbase.contracts.transport import TransportState
from rosbase.errors import NotADeviceError, TransportError
from rosbase.testing import strategies
from support.serial_network import PlayedSerial, Rfc2217Peer, SocketPeer, manager_of
from support.serial_rig import SerialRig, elapsed
from support.strategies import telnet_commands
from support.waiting import wait_until


@pytest.fixture
def peer() -> Iterator[Rfc2217Peer]:
    peer = Rfc2217Peer()
    yield peer
    peer.close()


@pytest.fixture
def plain() -> Iterator[SocketPeer]:
    """A server that knows nothing of telnet."""
    peer = SocketPeer()
    yield peer
    peer.close()


def test_the_port_is_set_to_8n1_without_flow_control_at_the_rate(
    rig: SerialRig, peer: Rfc2217Peer
) -> None:
    rig.transport(path=peer.url, baudrate=460_800).open()
    serial = peer.serial
    assert (serial.baudrate, serial.bytesize, serial.parity, serial.stopbits) == (
        460_800,
        8,
        "N",
        1,
    )
    assert (serial.xonxoff, serial.rtscts, serial.purged) == (False, False, 1)


WISHES = {"leave": None, "on": True, "off": False}


@pytest.mark.parametrize("rts", WISHES)
@pytest.mark.parametrize("dtr", WISHES)
def test_dtr_and_rts_are_set_once_or_left_alone(
    rig: SerialRig, peer: Rfc2217Peer, dtr: str, rts: str
) -> None:
    transport = rig.transport(path=peer.url, dtr=dtr, rts=rts)
    wanted = [
        (name, WISHES[wish]) for name, wish in (("dtr", dtr), ("rts", rts)) if wish != "leave"
    ]
    for times in (1, 2):
        transport.open()
        assert peer.serial.changes == wanted * times
        transport.start(rig.keep)
        transport.close()
    assert peer.serial.changes == wanted * 2, "closing changes nothing"


def test_a_line_comes_through_with_every_byte(rig: SerialRig, peer: Rfc2217Peer) -> None:
    transport = rig.transport(path=peer.url)
    transport.start(rig.keep)
    line = bytes(byte for byte in range(1, 256) if byte not in b"\r\n \t")
    peer.send(line)
    assert rig.next() == line


def test_a_server_that_stays_at_another_rate_is_refused(rig: SerialRig) -> None:
    class Stubborn(PlayedSerial):
        baudrate = property(lambda self: 9_600, lambda self, rate: None)

    peer = Rfc2217Peer(Stubborn())
    with pytest.raises(NotADeviceError, match="does not take 115200 baud: it stays at 9600"):
        rig.transport(path=peer.url, wait=True).open()
    peer.close()


def test_a_server_that_speaks_no_rfc2217_is_refused_with_what_to_write(
    rig: SerialRig, plain: SocketPeer
) -> None:
    refusing = threading.Thread(target=lambda: wait_and_send(plain, b"\xff\xfe\x2c"))
    refusing.start()
    with pytest.raises(NotADeviceError, match=r"does not speak RFC 2217; .* write socket://"):
        rig.transport(path=plain.url.replace("socket", "rfc2217")).open()
    refusing.join()


def wait_and_send(peer: SocketPeer, data: bytes) -> None:
    wait_until(lambda: peer.connections, "a connection")
    peer.send_raw(data)


@pytest.mark.parametrize("sends", [b"", b'{"acc":[0,0,9.8]}\n' * 50, b"\xff\xfa\x2c"])
def test_a_server_that_does_not_answer_is_refused_in_time(
    rig: SerialRig, plain: SocketPeer, sends: bytes
) -> None:
    transport = rig.transport(path=plain.url.replace("socket", "rfc2217"))
    sending = threading.Thread(target=lambda: wait_and_send(plain, sends))
    sending.start()

    def fails() -> None:
        with pytest.raises(TransportError, match="does not answer as RFC 2217 requires"):
            transport.open()

    assert elapsed(fails) < 5.0
    sending.join()


def test_what_is_not_telnet_and_does_not_end_is_refused(rig: SerialRig, plain: SocketPeer) -> None:
    sending = threading.Thread(target=lambda: wait_and_send(plain, b"\xff\xfa" + b"x" * 1_000))
    sending.start()
    with pytest.raises(NotADeviceError, match="something that is not telnet"):
        rig.transport(path=plain.url.replace("socket", "rfc2217")).open()
    sending.join()


def test_errors_on_the_line_that_the_server_tells_of_are_counted(
    rig: SerialRig, peer: Rfc2217Peer
) -> None:
    transport = rig.transport(path=peer.url)
    transport.start(rig.keep)
    for state in (b"\x08", b"\x0a", b"\x10", b"\x61"):
        peer.send_telnet(b"\xff\xfa\x2c\x6a" + state + b"\xff\xf0")
    wait_until(lambda: len(transport.health.link_errors) == 3, "the report")
    assert transport.health.link_errors == {"framing_error": 2, "overrun": 1, "line_break": 1}
    peer.send(b"still there")
    assert rig.next() == b"still there"


class Quiet(Rfc2217Peer):
    """A server that sets lines and does not say so."""

    def serve(self, client: socket.socket) -> None:
        def write(data: bytes) -> None:
            if data[3:4] != b"\x69":
                client.sendall(data)

        manager = manager_of(self.serial, write)
        while data := client.recv(1_000):
            for _ in manager.filter(data):
                pass


def test_a_line_of_which_the_server_says_nothing_is_named(
    rig: SerialRig, caplog: pytest.LogCaptureFixture
) -> None:
    peer = Quiet()
    transport = rig.transport(path=peer.url, dtr="off")
    transport.start(rig.keep)
    wait_until(lambda: "the server has not confirmed dtr" in caplog.text, "the remark")
    assert transport.health.state is TransportState.CONNECTED
    transport.close()
    peer.close()


def agreed() -> Rfc2217Client:
    client = Rfc2217Client(115_200)
    client.take_replies()
    return client


@given(
    st.data(),
    st.lists(
        st.binary(max_size=20).map(lambda data: ("data", data))
        | telnet_commands.map(lambda command: ("command", command)),
        max_size=12,
    ),
)
def test_data_comes_out_as_it_was_whatever_is_in_between_and_however_it_is_cut(
    data: st.DataObject, parts: list[tuple[str, bytes]]
) -> None:
    escape = manager_of(PlayedSerial(), lambda data: None).escape
    sent = b"".join(b"".join(escape(part)) if kind == "data" else part for kind, part in parts)
    client = agreed()
    chunks = data.draw(strategies.chunkings(sent))
    came = b"".join(client.feed(chunk) for chunk in chunks)
    assert came == b"".join(part for kind, part in parts if kind == "data")
    assert client.refusal == ""


@given(st.lists(st.binary(max_size=300), max_size=20))
def test_anything_at_all_keeps_replies_and_memory_bounded(chunks: list[bytes]) -> None:
    client = Rfc2217Client(115_200, "on", "off")
    replies = len(client.take_replies())
    for chunk in chunks:
        client.feed(chunk)
        replies += len(client.take_replies())
        assert len(client._held) <= 256
    # Four answers for each of 256 options, and the settings once.
    assert replies <= 4 * 3 * 256 + 200


@given(st.integers(1, 20_000_000))
def test_every_rate_is_understood_by_pyserial(baudrate: int) -> None:
    """As 0xff within a subnegotiation is doubled."""
    serial, client = PlayedSerial(), Rfc2217Client(baudrate)
    said: list[bytes] = []
    server = manager_of(serial, said.append)
    for _ in range(4):
        list(server.filter(client.take_replies()))
        client.feed(b"".join(said))
        said.clear()
    assert (serial.baudrate, client.rate) == (baudrate, baudrate)


def test_two_that_do_not_agree_do_not_go_on_for_ever() -> None:
    client = agreed()
    for _ in range(3):
        # What the client has asked for, and what it does not want.
        for telnet in (b"\xff\xfd\x00", b"\xff\xfb\x00", b"\xff\xfb\x01", b"\xff\xfd\x18"):
            client.feed(telnet)
    assert client.take_replies() == b"\xff\xfe\x01\xff\xfc\x18"


def test_the_settings_are_asked_for_once() -> None:
    client = agreed()
    client.feed(b"\xff\xfd\x2c")
    assert client.take_replies()
    client.feed(b"\xff\xfd\x2c\xff\xfb\x2c")
    assert client.take_replies() == b"\xff\xfd\x2c"
