"""Serial ports at the other end of a TCP connection: bytes as they are, and pyserial's RFC 2217."""

import select
import socket
import threading
from collections.abc import Callable, Mapping
from typing import Any

from serial.rfc2217 import PortManager

from rosbase.errors import TransportError
from rosbase.parameters import ParameterValue

__all__ = ["PlayedSerial", "Rfc2217Peer", "SocketPeer", "manager_of"]

_HOST = "127.0.0.1"


class SocketPeer:
    """Listens, and sends to whoever has connected last. Plays the device for the contract."""

    scheme = "socket"

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._client: socket.socket | None = None
        self._threads: list[threading.Thread] = []
        self.connections = 0
        self._server = self._listen(0)
        self.port: int = self._server.getsockname()[1]

    @property
    def url(self) -> str:
        return f"{self.scheme}://{_HOST}:{self.port}"

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        return {"device_path": self.url}

    def send(self, payload: bytes) -> None:
        self.send_raw(self.encode(payload))

    def encode(self, payload: bytes) -> bytes:
        return payload + b"\r\n"

    def send_raw(self, data: bytes) -> None:
        if self._server.fileno() < 0:
            raise TransportError(f"{self.url} has been closed")
        client = self._current()
        if client is not None:
            try:
                client.sendall(data)
            except OSError:
                # The reader has gone.
                pass

    def _current(self) -> socket.socket | None:
        """Who has connected last; who waits in the queue is taken."""
        with self._lock:
            while self._take_one(self._server):
                pass
            return self._client

    def unplug(self) -> None:
        if self._server.fileno() < 0:
            return
        # Ends the thread that waits for it; what has no more threads can be closed.
        self._server.shutdown(socket.SHUT_RDWR)
        self._threads[0].join(5)
        self._server.close()
        self.hang_up()
        for thread in self._threads:
            thread.join(5)
        self._threads.clear()

    close = unplug

    def replug(self) -> None:
        self._server = self._listen(self.port)

    def hang_up(self) -> None:
        """Ends the connection and goes on listening."""
        with self._lock:
            client, self._client = self._client, None
        if client is not None:
            _close(client)

    def serve(self, client: socket.socket) -> None:
        """What becomes of what a client sends, until it goes."""
        while client.recv(1_000):
            pass

    def _listen(self, port: int) -> socket.socket:
        server = socket.create_server((_HOST, port), backlog=200)
        server.settimeout(0)
        self._begin(lambda: self._accept(server))
        return server

    def _accept(self, server: socket.socket) -> None:
        waiting = select.poll()
        waiting.register(server, select.POLLIN)
        while not any(state & select.POLLHUP for _, state in waiting.poll()):
            with self._lock:
                self._take_one(server)

    def _take_one(self, server: socket.socket) -> bool:
        try:
            client, _ = server.accept()
        except OSError:
            return False
        client.settimeout(None)
        # A device sends each line when it has it.
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        before, self._client = self._client, client
        self.connections += 1
        if before is not None:
            _close(before)
        self._begin(lambda: self._attend(client))
        return True

    def _attend(self, client: socket.socket) -> None:
        try:
            self.serve(client)
        except OSError:
            pass
        finally:
            _close(client)

    def _begin(self, run: Callable[[], None]) -> None:
        # The first one accepts; it is there as long as the port is.
        self._threads = [thread for thread in self._threads if thread.is_alive()]
        thread = threading.Thread(target=run, name="serial-network", daemon=True)
        self._threads.append(thread)
        thread.start()


class PlayedSerial:
    """What a server of pyserial takes for a `serial.Serial`: notes what it is set to."""

    def __init__(self) -> None:
        self.baudrate = 9_600
        self.bytesize, self.parity, self.stopbits = 7, "E", 2
        self.xonxoff, self.rtscts = True, True
        self.break_condition = False
        self.cts = self.dsr = self.ri = self.cd = False
        self.changes: list[tuple[str, bool]] = []
        """Each time that a line was set: which, and to what."""
        self.purged = 0

    @property
    def dtr(self) -> bool:
        return dict(self.changes).get("dtr", True)

    @dtr.setter
    def dtr(self, is_on: bool) -> None:
        self.changes.append(("dtr", is_on))

    @property
    def rts(self) -> bool:
        return dict(self.changes).get("rts", True)

    @rts.setter
    def rts(self, is_on: bool) -> None:
        self.changes.append(("rts", is_on))

    def reset_input_buffer(self) -> None:
        self.purged += 1


class Rfc2217Peer(SocketPeer):
    """A server as pyserial brings one, in front of a port that notes what it is set to."""

    scheme = "rfc2217"

    def __init__(self, serial: PlayedSerial | None = None) -> None:
        self.serial = serial or PlayedSerial()
        super().__init__()

    def send_raw(self, data: bytes) -> None:
        super().send_raw(data.replace(b"\xff", b"\xff\xff"))

    def send_telnet(self, data: bytes) -> None:
        """Sends what is not of the port."""
        super().send_raw(data)

    def serve(self, client: socket.socket) -> None:
        manager = manager_of(self.serial, client.sendall)
        while data := client.recv(1_000):
            for _ in manager.filter(data):
                pass


def manager_of(serial: Any, write: Callable[[bytes], object]) -> PortManager:
    """pyserial's server in front of a played port; `write` sends to the client."""
    connection: Any = type("Connection", (), {"write": staticmethod(write)})()
    return PortManager(serial, connection)


def _close(client: socket.socket) -> None:
    try:
        client.shutdown(socket.SHUT_RDWR)
    except OSError:
        pass
    client.close()
