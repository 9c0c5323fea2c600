"""Optional capabilities of a transport, and the methods of a peer that they need."""

from collections.abc import Mapping
from typing import Protocol

from attrs import field, frozen

from rosbase.contracts.transport import SimulatedDevice
from rosbase.parameters import ParameterValue

__all__ = ["ABILITIES", "FullPeer", "TransportCapabilities"]


@frozen
class TransportCapabilities:
    """Capabilities that the contract may expect. Checks of undeclared ones are skipped."""

    is_stream: bool = False
    """Data is a byte stream without boundaries. The peer has `encode` and `send_raw`."""
    can_unplug: bool = False
    """The device can be lost, and the transport notices. The peer has `unplug` and `replug`."""
    can_be_absent: bool = False
    """`open` fails if there is no device. Checked with `unplug`, or else with `close`."""
    waits_with: Mapping[str, ParameterValue] = field(factory=dict)
    """Parameters with which `open` waits for an absent device. Needs `can_unplug`."""
    bad_frames: tuple[bytes, ...] = ()
    """Bytes for `send_raw` that the transport counts as errors and does not deliver."""
    reopens_with: Mapping[str, ParameterValue] = field(factory=dict)
    """Parameters with which a device that is silent for a fraction of a second is reopened."""
    frames_lost_after_junk: int = 1
    """Maximum number of frames lost or damaged after junk; for a stream."""


ABILITIES = {
    "is_stream": ("encode", "send_raw"),
    "can_unplug": ("unplug", "replug"),
    "bad_frames": ("send_raw",),
}
"""Methods that a capability needs in the peer."""


class FullPeer(SimulatedDevice, Protocol):
    """Simulated device, with its faults.

    Every peer has `parameters`, `send` and `close`. The rest is for the declared capabilities.
    """

    def encode(self, payload: bytes) -> bytes:
        """Return the bytes that `send` sends for a payload."""
        ...

    def send_raw(self, data: bytes) -> None:
        """Send raw bytes: junk, or a part of a frame. Without a stream, one message, maybe invalid.

        Raises:
            TransportError: The link has been closed.
        """
        ...

    def unplug(self) -> None:
        """Unplug the device."""
        ...

    def replug(self) -> None:
        """Plug the device in again, under the same name. Called after `unplug` only."""
        ...
