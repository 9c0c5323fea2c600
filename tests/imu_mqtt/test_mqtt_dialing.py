"""Reaching a broker: networks that stall, servers that speak something else, and stopping."""

import socket
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from imu_mqtt.packets import MOST_PACKET_BYTES
from rosbase.errors import DeviceNotFoundError, TransportError
from rosbase.testing.resources import memory_growth
from support.mqtt import GOOD, ScriptedBroker, publish_packet, sends
from support.mqtt_rig import MqttRig, elapsed, network_threads, warnings
from support.waiting import wait_until

Treatment = Callable[[socket.socket], None]


class Listener:
    """A server that treats each connection as the test says; or never takes one."""

    def __init__(
        self, server: socket.socket, treat: Callable[[socket.socket], None] | None
    ) -> None:
        self.server = server
        self.calls = 0
        self._treat = treat
        self._callers: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        if treat is None:
            self._fill()
        else:
            self._begin(self._accept)

    def close(self) -> None:
        if self._treat is not None:
            self.server.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join(20)
        for sock in (*self._callers, self.server):
            sock.close()

    def _fill(self) -> None:
        """Lets so many wait that nobody else gets through."""
        for _ in range(4):
            sock = socket.socket(self.server.family)
            sock.setblocking(False)
            sock.connect_ex(self.server.getsockname())
            self._callers.append(sock)

    def _begin(self, function: Callable[..., None], *arguments: socket.socket) -> None:
        self._threads.append(threading.Thread(target=function, args=arguments))
        self._threads[-1].start()

    def _accept(self) -> None:
        while True:
            try:
                sock, _ = self.server.accept()
            except OSError:
                return
            self.calls += 1
            self._begin(self._serve, sock)

    def _serve(self, sock: socket.socket) -> None:
        assert self._treat is not None
        with sock:
            try:
                self._treat(sock)
            except OSError:
                # The client has gone.
                pass


def on_tcp(treat: Treatment | None) -> Listener:
    return Listener(socket.create_server(("127.0.0.1", 0), backlog=0), treat)


def says_nothing(sock: socket.socket) -> None:
    while sock.recv(4_096):
        pass


def answers_in_drops(sock: socket.socket) -> None:
    sock.recv(4_096)
    sock.settimeout(0.1)
    for byte in b"HTTP/1.1 101 " + b"x" * 1_000:
        sock.sendall(bytes([byte]))
        try:
            if not sock.recv(4_096):
                return
        except TimeoutError:
            continue


def answers_otherwise(sock: socket.socket) -> None:
    """As a web server does that knows nothing of it, and has been told what to say."""
    sock.recv(4_096)
    sock.sendall(b"HTTP/1.1 404 Not\x1b[2J Found\nhere\r\nServer: web\r\n\r\n")


def answers_in_quick_drops(sock: socket.socket) -> None:
    """There is always something to read, and never all of it."""
    sock.recv(4_096)
    sock.settimeout(0.01)
    for byte in b"HTTP/1.1 101 " + b"x" * 5_000:
        sock.sendall(bytes([byte]))
        try:
            if not sock.recv(4_096):
                return
        except TimeoutError:
            continue


@pytest.fixture(
    params=["black hole", "unix, full", "silent TLS", "WebSocket in drops", "in quick drops"]
)
def stalled(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """The address of a broker that does not get anywhere."""
    kind = request.param
    if kind == "unix, full":
        server = socket.socket(socket.AF_UNIX)
        server.bind(str(tmp_path / "broker"))
        server.listen(0)
        listener, address = Listener(server, None), f"unix://{tmp_path / 'broker'}"
    else:
        treat, scheme = {
            "silent TLS": (says_nothing, "mqtts"),
            "WebSocket in drops": (answers_in_drops, "ws"),
            "in quick drops": (answers_in_quick_drops, "ws"),
        }.get(kind, (None, "tcp"))
        listener = on_tcp(treat)
        address = f"{scheme}://127.0.0.1:{listener.server.getsockname()[1]}"
    yield address
    listener.close()


def test_who_stalls_is_given_up_in_time(rig: MqttRig, stalled: str) -> None:
    transport = rig.transport(stalled)

    def opens() -> None:
        with pytest.raises(DeviceNotFoundError, match=f"^no answer from {stalled}$"):
            transport.open()

    assert elapsed(opens) < 4.0


def test_m10_who_stalls_does_not_hold_up_the_end(rig: MqttRig, stalled: str) -> None:
    transport = rig.transport(stalled)
    opening = threading.Thread(target=transport.open)
    opening.start()
    wait_until(network_threads, "the attempt")
    assert elapsed(transport.close) < 1.0
    opening.join()
    assert network_threads() == []


def test_of_several_addresses_one_that_swallows_everything_leaves_time_for_the_others(
    rig: MqttRig, broker: ScriptedBroker, monkeypatch: pytest.MonkeyPatch
) -> None:
    stalled = on_tcp(None)
    found = [
        (socket.AF_INET, socket.SOCK_STREAM, 0, "", server.getsockname())
        for server in (stalled.server, broker._server)
    ]
    monkeypatch.setattr(socket, "getaddrinfo", lambda *args, **kwargs: found)
    transport = rig.transport("tcp://several.test:1883")
    assert elapsed(transport.open) < 2.0
    assert transport.is_open
    stalled.close()


def test_a_websocket_that_answers_in_its_own_way_is_one_line_and_tried_again(
    rig: MqttRig, caplog: pytest.LogCaptureFixture
) -> None:
    listener = on_tcp(answers_otherwise)
    address = f"ws://127.0.0.1:{listener.server.getsockname()[1]}"
    with pytest.raises(TransportError) as caught:
        rig.transport(address).open()
    said = r"HTTP/1.1 404 Not\x1b[2J Found\nhere"
    assert str(caught.value) == f"{address} accepts no WebSocket for MQTT: {said}"
    transport = rig.transport(address, wait_for_broker=True)
    transport.open()
    calls = listener.calls
    wait_until(lambda: listener.calls > calls + 1, "more tries")
    assert len(warnings(caplog)) == 1
    transport.close()
    listener.close()


@pytest.mark.parametrize("qos", [0, 1])
def test_m12_of_a_huge_message_only_the_ends_are_kept_and_the_next_comes_through(
    rig: MqttRig, broker: ScriptedBroker, qos: int
) -> None:
    huge = publish_packet(b"esp32/imu", b"x" * 40_000_000, duplicate=bool(qos))
    broker.behaviour = sends(huge, huge, GOOD)
    with memory_growth() as growth:
        transport = rig.started(broker.address, qos=qos)
        assert rig.next() == b"good"
        assert growth() < 10 * MOST_PACKET_BYTES
    assert transport.health.frame_errors == {"overlong": 2}
    assert transport.health.reconnects == 0
