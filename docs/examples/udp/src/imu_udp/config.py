"""The parameters of a UDP port, and the settings that their values amount to."""

import ipaddress
from collections.abc import Mapping

from attrs import frozen

from rosbase import ParameterError, ParameterSpec, ParameterValue

__all__ = ["PARAMETERS", "UdpConfig"]

PARAMETERS: tuple[ParameterSpec, ...] = (
    ParameterSpec(
        "udp_address",
        "0.0.0.0:5005",
        "where datagrams arrive: an address of this machine and a port, such as [::]:5005",
    ),
    ParameterSpec("udp_sender", "", "the only address that is heard; empty for anybody"),
)
"""What the transport adds to a reader's parameters. The first says which device it is."""


@frozen
class UdpConfig:
    """Where to listen, and to whom."""

    host: str
    port: int
    sender: str

    @classmethod
    def from_values(cls, values: Mapping[str, ParameterValue]) -> "UdpConfig":
        """The settings from checked parameter values.

        Raises:
            ParameterError: One of them is no address.
        """
        text, sender = str(values["udp_address"]), str(values["udp_sender"])
        host, _, port = text.rpartition(":")
        host = host.removeprefix("[").removesuffix("]")
        if not (_is_address(host) and port.isdecimal() and 0 < int(port) < 65_536):
            raise ParameterError(f"udp_address is like 0.0.0.0:5005 or [::]:5005, not {text!r}")
        if sender and not _is_address(sender):
            raise ParameterError(f"udp_sender is an address such as 192.168.1.7, not {sender!r}")
        return cls(host, int(port), sender)


def _is_address(text: str) -> bool:
    try:
        ipaddress.ip_address(text)
    except ValueError:
        return False
    return True
