"""Reach a broker within a time limit, even if the network stalls, and only while it is wanted."""

import errno
import os
import select
import socket
import ssl
from collections.abc import Callable
from typing import Any

from imu_mqtt.config import Address, MqttConfig
from rosbase import (
    Clock,
    DeviceNotFoundError,
    DevicePermissionError,
    TransportError,
    one_line,
)

__all__ = [
    "DIAL_TIMEOUT_S",
    "Dial",
    "RefusedError",
    "TlsError",
    "tls_context",
    "unreachable",
    "words_of",
]

DIAL_TIMEOUT_S = 2.0
"""Timeout for reaching the broker, TLS and WebSocket included."""

# How soon it is noticed that nobody wants it any more.
_LOOK_S = 0.05
_READ_BYTES = 4_096
# X509_V_ERR_HOSTNAME_MISMATCH, X509_V_ERR_IP_ADDRESS_MISMATCH
_WRONG_NAME = (62, 64)


class RefusedError(DevicePermissionError):
    """The broker refuses this client as it is: trying again at once cannot help."""

    def __init__(self, text: str, advice: str = "") -> None:
        """Take the advice for the user, where it is known."""
        super().__init__(text)
        self.advice = advice


class TlsError(RefusedError):
    """TLS failed: one side does not trust the other, or has no TLS."""


class Dial:
    """One attempt to reach a broker, with a time limit for all but the look-up of its name."""

    def __init__(self, clock: Clock, is_wanted: Callable[[], bool], limit_s: float) -> None:
        """Start the time limit."""
        self._clock = clock
        self._is_wanted = is_wanted
        self._deadline_ns = clock.monotonic_ns() + int(limit_s * 1e9)

    def reach(self, address: Address) -> socket.socket:
        """Return a connected socket that never waits.

        Raises:
            OSError: Nobody answers, or not in time; the last reason of several.
        """
        if address.scheme == "unix":
            return self._connect(socket.AF_UNIX, address.host, self._left_s)
        kind = socket.SOCK_STREAM
        found = socket.getaddrinfo(address.host, address.port, type=kind)
        failure: OSError | None = None
        for number, (family, _, _, _, place) in enumerate(found):
            try:
                # A share each, so that an address that swallows everything leaves time for others.
                return self._connect(family, place, self._left_s / (len(found) - number))
            except OSError as error:
                failure = error
        raise failure or TimeoutError

    def wait(self, sock: socket.socket, events: int, limit_s: float | None = None) -> None:
        """Wait until the socket can be read or written.

        Raises:
            TimeoutError: It cannot in time, or the connection is not wanted any more.
        """
        poll = select.poll()
        poll.register(sock, events)
        left_s = self._left_s if limit_s is None else min(limit_s, self._left_s)
        deadline_ns = self._clock.monotonic_ns() + int(left_s * 1e9)
        # First, because who sends a byte at a time can always be read.
        self._check(deadline_ns)
        while not poll.poll(_LOOK_S * 1000.0):
            self._check(deadline_ns)

    def send(self, sock: socket.socket, data: bytes) -> None:
        """Send all data. Raises OSError."""
        while data:
            try:
                data = data[sock.send(data) :]
            except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
                self.wait(sock, select.POLLOUT)

    def receive(self, sock: socket.socket) -> bytes:
        """Wait for some data; return nothing when the other end has closed it. Raises OSError."""
        while True:
            self._check(self._deadline_ns)
            try:
                return sock.recv(_READ_BYTES)
            except (BlockingIOError, ssl.SSLWantReadError, ssl.SSLWantWriteError):
                self.wait(sock, select.POLLIN)

    def shake_hands(self, sock: ssl.SSLSocket) -> None:
        """Run the TLS handshake. Raises OSError."""
        while True:
            try:
                sock.do_handshake()
                return
            except ssl.SSLWantReadError:
                self.wait(sock, select.POLLIN)
            except ssl.SSLWantWriteError:
                self.wait(sock, select.POLLOUT)

    @property
    def _left_s(self) -> float:
        return (self._deadline_ns - self._clock.monotonic_ns()) / 1e9

    def _check(self, deadline_ns: int) -> None:
        if not self._is_wanted() or self._clock.monotonic_ns() > deadline_ns:
            raise TimeoutError

    def _connect(self, family: int, place: Any, limit_s: float) -> socket.socket:
        sock = socket.socket(family, socket.SOCK_STREAM)
        try:
            sock.settimeout(0.0)
            while (code := sock.connect_ex(place)) == errno.EAGAIN:
                # Of a Unix socket: more have called than it lets wait.
                self._check(self._deadline_ns)
                self._clock.sleep(_LOOK_S)
            if code == errno.EINPROGRESS:
                self.wait(sock, select.POLLOUT, limit_s)
                code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
            if code:
                raise OSError(code, os.strerror(code))
        except BaseException:
            sock.close()
            raise
        return sock


def tls_context(config: MqttConfig) -> ssl.SSLContext | None:
    """Return the TLS context of a secure connection; None for a plain one.

    Raises:
        TlsError: A file is missing or invalid.
    """
    if not config.address.is_secure:
        return None
    named = config.ca_file
    try:
        context = ssl.create_default_context(cafile=config.ca_file or None)
        if config.cert_file:
            named = ", ".join(filter(None, (config.cert_file, config.key_file)))
            # A password, for OpenSSL asks the terminal if there is none.
            context.load_cert_chain(config.cert_file, config.key_file or None, password="")
    except (OSError, ValueError) as error:
        advice = "give PEM files, and the certificate's own key, without a passphrase"
        raise TlsError(f"{named} cannot be used for TLS: {words_of(error)}", advice) from error
    return context


def unreachable(address: Address, error: Exception) -> TransportError:
    """Return the message to the user for an error while dialing."""
    if address.is_secure and isinstance(error, (ConnectionResetError, ssl.SSLEOFError)):
        # A broker that is being restarted does so too, so this is no reason to try less often.
        return TransportError(
            f"{address} ended the TLS handshake; if it does not use TLS, use tcp:// or ws://"
        )
    if isinstance(error, ssl.SSLError):
        return TlsError(f"{address}: TLS fails: {words_of(error)}", _advice_on_tls(error))
    if isinstance(error, (ConnectionRefusedError, FileNotFoundError)):
        return DeviceNotFoundError(f"there is no broker at {address}")
    if isinstance(error, socket.gaierror):
        return DeviceNotFoundError(f"{address}: unknown host name: {words_of(error)}")
    if isinstance(error, TimeoutError):
        return DeviceNotFoundError(f"no answer from {address}")
    if address.scheme in ("ws", "wss") and getattr(error, "errno", None) is None:
        return TransportError(f"{address} accepts no WebSocket for MQTT: {words_of(error)}")
    return TransportError(f"{address}: {words_of(error)}")


def _advice_on_tls(error: ssl.SSLError) -> str:
    if isinstance(error, ssl.SSLCertVerificationError):
        if error.verify_code in _WRONG_NAME:
            return "the address must be a name in the broker's certificate"
        return "tls_ca_file must hold the CA certificate that signed the broker's"
    if "ALERT" in (error.reason or ""):
        return "tls_cert_file and tls_key_file must hold a certificate that the broker trusts"
    return "does this port use TLS? if not, use tcp:// or ws://"


def words_of(error: Exception) -> str:
    """Return the text of an error from the system or TLS, in one line."""
    reason = getattr(error, "verify_message", "") or getattr(error, "strerror", "") or str(error)
    return one_line(str(reason))
