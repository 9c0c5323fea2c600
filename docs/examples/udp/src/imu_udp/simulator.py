"""A stand-in for a device: sends datagrams to a port of this machine."""

import socket
from collections.abc import Mapping

from rosbase import ParameterValue, TransportError

__all__ = ["UdpDevice"]


class UdpDevice:
    """A device on the loopback interface: a `rosbase.SimulatedDevice`."""

    def __init__(self) -> None:
        """Chooses a port that nobody uses."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self._to = probe.getsockname()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """What the transport must be given to reach this device."""
        return {"udp_address": f"127.0.0.1:{self._to[1]}", "udp_sender": "127.0.0.1"}

    def send(self, payload: bytes) -> None:
        """Sends one payload.

        Raises:
            TransportError: The device has been closed.
        """
        try:
            self._socket.sendto(payload, self._to)
        except OSError as error:
            raise TransportError(f"the simulated device: {error.strerror}") from error

    def close(self) -> None:
        """Sends no more. Idempotent."""
        self._socket.close()
