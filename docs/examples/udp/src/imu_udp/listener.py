"""The socket that datagrams arrive at. The only module that touches the network."""

import errno
import socket

from imu_udp.config import UdpConfig
from rosbase import DeviceBusyError, DeviceNotFoundError, DevicePermissionError, TransportError

__all__ = ["Listener"]

# The largest datagram there is.
_DATAGRAM_BYTES = 65_535
# Discarding must end, however fast somebody sends.
_MOST_DISCARDED = 10_000
_REASONS: dict[int | None, tuple[type[TransportError], str]] = {
    errno.EADDRINUSE: (DeviceBusyError, "is in use by another program"),
    errno.EADDRNOTAVAIL: (DeviceNotFoundError, "is no address of this machine"),
    errno.EACCES: (DevicePermissionError, "may not be opened by this user"),
}


class Listener:
    """A port that datagrams arrive at: a `rosbase.Device`."""

    def __init__(self, config: UdpConfig) -> None:
        """Opens it.

        Raises:
            TransportError: Which kind says why; the message is one line.
        """
        self.name = f"UDP port {config.port} of {config.host}"
        """What it is called in a line of text."""
        self._sender = config.sender
        family = socket.AF_INET6 if ":" in config.host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.settimeout(0)
        try:
            self._socket.bind((config.host, config.port))
        except OSError as error:
            self._socket.close()
            kind, why = _REASONS.get(error.errno, (TransportError, error.strerror))
            raise kind(f"{self.name} {why}") from error
        self.fileno = self._socket.fileno

    def read(self) -> bytes:
        """One datagram; empty if it is not for us.

        Raises:
            TransportError: The socket is of no use any more.
        """
        try:
            data, sender = self._socket.recvfrom(_DATAGRAM_BYTES)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise TransportError(f"{self.name} was lost: {error.strerror}") from error
        return b"" if self._sender and sender[0] != self._sender else data

    def discard_input(self) -> None:
        """Forgets the datagrams that wait.

        Raises:
            TransportError: The socket is of no use any more.
        """
        for _ in range(_MOST_DISCARDED):
            try:
                self._socket.recvfrom(_DATAGRAM_BYTES)
            except BlockingIOError:
                return
            except OSError as error:
                raise TransportError(f"{self.name} was lost: {error.strerror}") from error

    def close(self) -> None:
        """Gives the port back."""
        self._socket.close()
