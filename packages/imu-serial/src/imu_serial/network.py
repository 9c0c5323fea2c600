"""A port at the other end of a TCP connection: bytes as they are, or RFC 2217."""

import errno
import os
import select
import socket
import threading
from typing import Any

from attrs import define, field

from imu_serial.address import Address
from imu_serial.config import SerialConfig
from imu_serial.rfc2217 import Rfc2217Client
from rosbase import (
    Clock,
    Device,
    DeviceNotFoundError,
    DeviceReport,
    NotADeviceError,
    TransportError,
    background_thread,
)

__all__ = ["Dialer", "Link", "NoAnswerError"]

# `stop` may have to wait for a try.
_LIMIT_S = 0.8
_CHUNK_BYTES = 65_536
# Discarding must end, however fast somebody sends.
_MOST_DISCARDED = 1_000
# A peer that is gone without a word is noticed after 5 + 3 * 5 seconds.
_KEEPALIVE = (
    (socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1),
    (socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, 5),
    (socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, 5),
    (socket.IPPROTO_TCP, socket.TCP_KEEPCNT, 3),
)


class NoAnswerError(DeviceNotFoundError):
    """Nobody answers in time: a network loses packets, and looking up names takes time."""

    passes_soon = True


class Dialer:
    """Connects to an address: each time within a second, the look-up of its name included."""

    def __init__(self, config: SerialConfig, address: Address, clock: Clock) -> None:
        """Take the settings; touch no network yet."""
        self._config = config
        self._address = address
        self._clock = clock
        self._look_up: _LookUp | None = None

    def open(self) -> Device:
        """Return a link that is ready to be read.

        Raises:
            TransportError: Nobody answers, or another kind of server does.
        """
        deadline_ns = self._clock.monotonic_ns() + int(_LIMIT_S * 1e9)
        try:
            sock = self._connect(deadline_ns)
        except OSError as error:
            raise _unreachable(self._address, error) from error
        try:
            if self._address.scheme == "socket":
                return Link(str(self._address), sock)
            return self._negotiated(sock, deadline_ns)
        except BaseException:
            sock.close()
            raise

    def _connect(self, deadline_ns: int) -> socket.socket:
        places = self._places(deadline_ns)
        failure: OSError = TimeoutError()
        for number, (family, _, _, _, place) in enumerate(places):
            # A share each, so that an address that swallows everything leaves time for others.
            share_s = self._left_s(deadline_ns) / (len(places) - number)
            try:
                return _connected(family, place, share_s)
            except OSError as error:
                failure = error
        raise failure

    def _places(self, deadline_ns: int) -> list[Any]:
        """Return the addresses of the host. The look-up may hang, so it runs on a thread."""
        host, port = self._address.host, self._address.port
        try:
            numeric = socket.AI_NUMERICHOST
            return socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=numeric)
        except (socket.gaierror, UnicodeError):
            # It is a name; or is none, which the look-up finds out.
            pass
        # One that is slow goes on while others think that it has failed.
        look_up = self._look_up or _LookUp(host, port)
        self._look_up = look_up
        if not look_up.has_ended.wait(max(0.0, self._left_s(deadline_ns))):
            raise TimeoutError
        self._look_up = None
        if look_up.failure is not None:
            raise look_up.failure
        return look_up.places

    def _negotiated(self, sock: socket.socket, deadline_ns: int) -> "Link":
        config, address = self._config, self._address
        client = Rfc2217Client(config.baudrate, config.dtr, config.rts)
        link = Link(f"{address} at {config.baudrate} baud", sock, client)
        readable = select.poll()
        readable.register(sock, select.POLLIN)
        link.reply()
        while client.rate is None:
            if not readable.poll(max(0.0, self._left_s(deadline_ns)) * 1000.0):
                raise NoAnswerError(f"{address} does not answer as RFC 2217 requires")
            link.read()
        if client.rate != config.baudrate:
            raise NotADeviceError(
                f"{address} does not take {config.baudrate} baud: it stays at {client.rate}"
            )
        return link

    def _left_s(self, deadline_ns: int) -> float:
        return (deadline_ns - self._clock.monotonic_ns()) / 1e9


class Link:
    """An open connection: a `rosbase.ReportingDevice`."""

    def __init__(self, name: str, sock: socket.socket, client: Rfc2217Client | None = None) -> None:
        """Take a connected socket."""
        self.name = name
        """Name for the log line when it is opened."""
        self._socket = sock
        self._client = client
        self._has_reported = False
        # Read into one buffer: a new one for each chunk, cut to size, would fragment the heap.
        self._buffer = bytearray(_CHUNK_BYTES)
        self._view = memoryview(self._buffer)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._socket.fileno()

    def read(self) -> bytes:
        """Return arrived data, as much as one read gives.

        Raises:
            TransportError: The connection has ended.
        """
        received = self._received()
        return received if self._client is None else self._port_data(self._client, received)

    def discard_input(self) -> None:
        """Discard arrived data that was not read.

        Raises:
            TransportError: The connection has ended.
        """
        for _ in range(_MOST_DISCARDED):
            if not (received := self._received()):
                break
            if self._client is not None:
                self._port_data(self._client, received)

    def report(self, is_quiet: bool) -> DeviceReport:
        """Return the errors reported by the server, and the requests that it has not fulfilled."""
        client = self._client
        if client is None:
            return DeviceReport()
        errors, client.errors = client.errors, {}
        remark = ""
        if not self._has_reported and client.unconfirmed:
            remark = f"{self.name}: the server has not confirmed {' and '.join(client.unconfirmed)}"
        self._has_reported = True
        return DeviceReport(errors=errors, remark=remark)

    def reply(self) -> None:
        """Send the replies that the protocol asks for.

        Raises:
            TransportError: The connection has ended.
        """
        replies = self._client.take_replies() if self._client is not None else b""
        try:
            # A few bytes at a time, for which there is always room.
            if replies and self._socket.send(replies) < len(replies):
                raise self._lost("it accepts no data")
        except OSError as error:
            raise self._lost(error.strerror or str(error)) from error

    def close(self) -> None:
        """End the connection."""
        self._socket.close()

    def _received(self) -> bytes:
        try:
            size = self._socket.recv_into(self._buffer)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise self._lost(error.strerror or str(error)) from error
        if not size:
            raise self._lost("the other end has closed the connection")
        return bytes(self._view[:size])

    def _port_data(self, client: Rfc2217Client, received: bytes) -> bytes:
        data = client.feed(received)
        if client.refusal:
            raise NotADeviceError(f"{self.name}: {client.refusal}")
        self.reply()
        return data

    def _lost(self, why: str) -> TransportError:
        return TransportError(f"{self.name} was lost: {why}")


@define
class _LookUp:
    """The look-up of a name, on a thread that nobody must wait for."""

    host: str
    port: int
    places: list[Any] = field(factory=list)
    failure: OSError | None = None
    has_ended: threading.Event = field(factory=threading.Event)

    def __attrs_post_init__(self) -> None:
        background_thread(self._run, "rosbase-look-up").start()

    def _run(self) -> None:
        try:
            self.places = socket.getaddrinfo(self.host, self.port, type=socket.SOCK_STREAM)
        except (OSError, UnicodeError) as error:
            # A name that cannot be one is a UnicodeError.
            unknown = socket.gaierror(socket.EAI_NONAME, "Name or service not known")
            self.failure = error if isinstance(error, OSError) else unknown
        finally:
            self.has_ended.set()


def _connected(family: int, place: Any, limit_s: float) -> socket.socket:
    """Return a connected socket with keepalive that never waits."""
    sock = socket.socket(family, socket.SOCK_STREAM)
    try:
        sock.settimeout(0.0)
        for level, option, value in _KEEPALIVE:
            sock.setsockopt(level, option, value)
        code = sock.connect_ex(place)
        if code == errno.EINPROGRESS:
            ready = select.poll()
            ready.register(sock, select.POLLOUT)
            if not ready.poll(max(0.0, limit_s) * 1000.0):
                raise TimeoutError
            code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            raise OSError(code, os.strerror(code))
    except BaseException:
        sock.close()
        raise
    return sock


def _unreachable(address: Address, error: OSError) -> TransportError:
    match error:
        case ConnectionRefusedError():
            return DeviceNotFoundError(f"{address}: nothing listens there")
        case socket.gaierror():
            return DeviceNotFoundError(f"{address}: unknown host name")
        case TimeoutError():
            return NoAnswerError(f"{address}: no answer")
    return DeviceNotFoundError(f"{address} cannot be reached: {error.strerror or error}")
