"""`socket://`: a port behind TCP, reached within limits, and said what is wrong with it."""

import errno
import os
import shutil
import socket
import subprocess
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from imu_serial.address import Address, parse_address
from imu_serial.check import _SERVE
from imu_serial.config import PARAMETERS, SerialConfig
from imu_serial.network import Dialer, Link
from rosbase.clock import SystemClock
from rosbase.contracts.transport import TransportState
from rosbase.errors import DeviceNotFoundError, ParameterError, TransportError
from rosbase.parameters import ParameterValue
from support.serial_network import SocketPeer
from support.serial_rig import SerialRig, elapsed, wait_for_state
from support.waiting import wait_until


@pytest.fixture
def peer() -> Iterator[SocketPeer]:
    peer = SocketPeer()
    yield peer
    peer.close()


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("socket://192.168.1.20:7000", Address("socket", "192.168.1.20", 7000)),
        ("SOCKET://esp32.local:23/", Address("socket", "esp32.local", 23)),
        ("rfc2217://[fe80::1]:2217", Address("rfc2217", "fe80::1", 2217)),
        ("/dev/ttyUSB0", None),
        ("COM4", None),
        ("./socket:/x", None),
    ],
)
def test_an_address_is_told_from_a_path(text: str, address: Address | None) -> None:
    assert parse_address(text) == address


def test_an_address_is_written_as_it_is_read() -> None:
    for text in ("socket://host:7000", "rfc2217://[::1]:1"):
        assert str(parse_address(text)) == text


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("socket://host", "is not host and port"),
        ("socket://:7000", "is not host and port"),
        ("socket://host:0", "is not host and port"),
        ("socket://host:65536", "is not host and port"),
        ("socket://host:port", "is not host and port"),
        ("socket://[::1:7000", "is not host and port"),
        ("socket://user@host:7000", "is not host and port"),
        ("socket://host:7000/tty", "is not host and port"),
        ("rfc2217://host:7000?ign_set_control", "is not host and port"),
        ("socket://ho\nst:7000", "is not host and port"),
        ("tcp://host:7000", "write socket://host:port"),
        ("telnet://host", "write socket://host:port"),
        ("loop://", "loop:// is not supported; socket://host:port and rfc2217"),
        ("spy:///dev/ttyUSB0", "is not supported"),
        ("serial:///dev/ttyUSB0:57600", "write the path alone"),
        ("file:///dev/ttyUSB0", "write the path alone"),
    ],
)
def test_what_is_no_address_is_refused_at_the_start_in_one_line(text: str, says: str) -> None:
    with pytest.raises(ParameterError, match=says) as caught:
        SerialConfig.from_values({"device_path": text})
    assert "\n" not in str(caught.value)
    assert "plugged in" not in str(caught.value)


@pytest.mark.parametrize(("name", "value"), [("dtr", "off"), ("rts", "on"), ("baudrate", 9_600)])
def test_what_plain_bytes_cannot_carry_is_refused_at_the_start(
    name: str, value: ParameterValue
) -> None:
    values = {spec.name: spec.default for spec in PARAMETERS} | {name: value}
    with pytest.raises(ParameterError, match=f"parameter {name} has no effect on socket://h:1"):
        SerialConfig.from_values(values | {"device_path": "socket://h:1"})
    SerialConfig.from_values(values | {"device_path": "rfc2217://h:1"})
    SerialConfig.from_values(values | {"device_path": "/dev/ttyUSB0"})


def test_lines_come_over_tcp_and_a_connection_that_ends_is_made_again(
    rig: SerialRig, peer: SocketPeer
) -> None:
    transport = rig.transport(path=peer.url)
    transport.start(rig.keep)
    for times in range(3):
        peer.send(b"line %d" % times)
        assert rig.next() == b"line %d" % times
        peer.hang_up()
        wait_until(lambda: transport.health.reconnects > times, "the return")  # noqa: B023 - called in this turn of the loop
        wait_for_state(transport, TransportState.CONNECTED)


def test_nobody_there_is_not_a_device_that_is_unplugged(rig: SerialRig, peer: SocketPeer) -> None:
    peer.unplug()
    with pytest.raises(DeviceNotFoundError, match=f"^{peer.url}: nothing listens there$"):
        rig.transport(path=peer.url).open()


def test_a_name_that_nobody_knows_is_said(rig: SerialRig) -> None:
    for name in ("no-such-host.invalid", "x" * 70 + ".invalid"):
        with pytest.raises(DeviceNotFoundError, match="unknown host name"):
            rig.transport(path=f"socket://{name}:7000").open()


def test_a_network_without_a_way_there_is_said(
    rig: SerialRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_route(sock: socket.socket, place: object) -> int:
        return errno.EHOSTUNREACH

    monkeypatch.setattr(socket.socket, "connect_ex", no_route)
    with pytest.raises(DeviceNotFoundError, match="cannot be reached: No route to host"):
        rig.transport(path="socket://192.0.2.1:7000").open()


def full_listener() -> tuple[socket.socket, list[socket.socket]]:
    """A port of which the queue is full: the kernel drops who comes then, without a word."""
    server = socket.socket()
    server.bind(("127.0.0.1", 0))
    server.listen(0)
    waiting = []
    for _ in range(3):
        client = socket.socket()
        client.setblocking(False)
        client.connect_ex(server.getsockname())
        waiting.append(client)
    return server, waiting


@pytest.mark.parametrize("wait", [False, True])
def test_every_call_is_bounded_where_nobody_answers(rig: SerialRig, wait: bool) -> None:
    server, waiting = full_listener()
    transport = rig.transport(path=f"socket://127.0.0.1:{server.getsockname()[1]}", wait=wait)

    def opens() -> None:
        if wait:
            transport.open()
            return
        with pytest.raises(DeviceNotFoundError, match="no answer"):
            transport.open()

    assert 3.0 < elapsed(opens) < 5.0, "it is given some seconds"
    if wait:
        transport.start(rig.keep)
        # Into the middle of a try.
        wait_until(lambda: connecting(server.getsockname()[1]), "a try on the reader thread")
        assert elapsed(transport.stop) < 1.0
    for sock in (server, *waiting):
        sock.close()


def connecting(port: int) -> bool:
    """Whether a connection of this process to the port is being made (SYN_SENT)."""
    with open("/proc/net/tcp") as table:
        return any(f":{port:04X} 02" in line for line in table)


def test_a_stop_while_it_opens_on_another_thread_does_not_wait_for_the_patience(
    rig: SerialRig,
) -> None:
    server, waiting = full_listener()
    transport = rig.transport(path=f"socket://127.0.0.1:{server.getsockname()[1]}", wait=True)
    thread = threading.Thread(target=transport.open)
    thread.start()
    wait_until(lambda: connecting(server.getsockname()[1]), "a try")
    assert elapsed(transport.close) < 1.0
    thread.join(5)
    assert not thread.is_alive()
    for sock in (server, *waiting):
        sock.close()


def test_a_name_that_takes_long_to_be_found_holds_up_nothing_and_is_used_in_the_end(
    rig: SerialRig, peer: SocketPeer, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers, asked = threading.Event(), []
    real = socket.getaddrinfo

    def slow(host: str, *args: Any, **kwargs: Any) -> object:
        if kwargs.get("flags"):
            raise socket.gaierror(socket.EAI_NONAME, "not a number")
        asked.append(host)
        answers.wait(30)
        return real("127.0.0.1", *args, **kwargs)

    monkeypatch.setattr(socket, "getaddrinfo", slow)
    transport = rig.transport(path=f"socket://esp32.local:{peer.port}", wait=True)
    assert elapsed(transport.open) < 5.0
    transport.start(rig.keep)
    assert elapsed(transport.stop) < 1.0
    transport.start(rig.keep)
    answers.set()
    wait_for_state(transport, TransportState.CONNECTED)
    assert len(asked) < 3, "one look-up goes on from try to try"
    peer.send(b"found")
    assert rig.next() == b"found"


def test_each_address_of_a_name_is_tried(
    rig: SerialRig, peer: SocketPeer, monkeypatch: pytest.MonkeyPatch
) -> None:
    server, waiting = full_listener()
    real = socket.getaddrinfo

    def two(host: str, port: int, **kwargs: object) -> object:
        if kwargs.get("flags"):
            raise socket.gaierror(socket.EAI_NONAME, "not a number")
        dead = server.getsockname()
        (alive,) = real("127.0.0.1", port, type=socket.SOCK_STREAM)
        return [(*alive[:4], dead), alive]

    monkeypatch.setattr(socket, "getaddrinfo", two)
    transport = rig.transport(path=f"socket://both:{peer.port}")
    assert elapsed(transport.open) < 0.75, "each has its share"
    assert transport.is_open
    for sock in (server, *waiting):
        sock.close()


def test_a_connection_watches_over_itself(peer: SocketPeer) -> None:
    """So that a peer whose power is cut is noticed, which no test can do on loopback."""
    config = SerialConfig(peer.url, 115_200)
    address = config.address
    assert address is not None
    link = Dialer(config, address, SystemClock()).open()
    with socket.socket(fileno=os.dup(link.fileno())) as sock:
        assert sock.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE) == 1
        idle, interval, count = (
            sock.getsockopt(socket.IPPROTO_TCP, option)
            for option in (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT)
        )
    assert idle + interval * count <= 30
    link.close()


class Flooded(socket.socket):
    """Somebody sends faster than anybody reads."""

    reads = 0

    def recv_into(self, *args: object) -> int:
        self.reads += 1
        assert self.reads < 10_000, "it reads on and on"
        return 1_000


def test_discarding_ends_however_fast_somebody_sends() -> None:
    link = Link("the link", Flooded())
    link.discard_input()
    link.close()


def test_a_connection_that_has_ended_is_lost() -> None:
    ours, theirs = socket.socketpair()
    ours.settimeout(0)
    link = Link("the link", ours)
    theirs.send(b"x")
    assert (link.read(), link.read()) == (b"x", b"")
    ours.shutdown(socket.SHUT_RD)
    with pytest.raises(TransportError, match="the link was lost: the other end has closed"):
        link.read()
    link.close()
    theirs.close()


@pytest.mark.skipif(shutil.which("socat") is None, reason="socat is not installed")
def test_the_line_for_socat_serves_a_port(rig: SerialRig) -> None:
    """The one that the doctor and the README give."""
    rig.port.plug()
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    address = Address("socket", "127.0.0.1", port)
    command = _SERVE["socket"].format(address).replace("/dev/ttyUSB0", rig.port.real_path)
    with subprocess.Popen(command.split()) as socat:
        transport = rig.transport(path=str(address), wait=True)
        transport.open()
        transport.start(rig.keep)
        wait_for_state(transport, TransportState.CONNECTED)
        rig.prove()
        transport.close()
        socat.terminate()
