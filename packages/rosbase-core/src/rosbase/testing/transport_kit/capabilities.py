"""What a transport can do beside what all can, and what the peer must be able to do for that."""

from collections.abc import Mapping
from typing import Protocol

from attrs import field, frozen

from rosbase.contracts.transport import SimulatedDevice
from rosbase.parameters import ParameterValue

__all__ = ["ABILITIES", "FullPeer", "TransportCapabilities"]


@frozen
class TransportCapabilities:
    """What the contract may expect. A check that needs what is not declared is skipped."""

    is_stream: bool = False
    """Bytes arrive without borders. The peer has `encode` and `send_raw`."""
    can_unplug: bool = False
    """The device can be lost, and the transport notices. The peer has `unplug` and `replug`."""
    can_be_absent: bool = False
    """`open` fails where there is no device. Found out with `unplug`, or else with `close`."""
    waits_with: Mapping[str, ParameterValue] = field(factory=dict)
    """The parameters with which `open` waits for a device that is absent. Needs `can_unplug`."""
    bad_frames: tuple[bytes, ...] = ()
    """What `send_raw` sends, and the transport counts as an error and does not hand over."""
    reopens_with: Mapping[str, ParameterValue] = field(factory=dict)
    """The parameters with which a device that is silent for a part of a second is opened anew."""
    frames_lost_after_junk: int = 1
    """How many frames at most are lost or spoiled after junk; for a stream."""


ABILITIES = {
    "is_stream": ("encode", "send_raw"),
    "can_unplug": ("unplug", "replug"),
    "bad_frames": ("send_raw",),
}
"""What the peer must have for a capability."""


class FullPeer(SimulatedDevice, Protocol):
    """Plays the device, and whatever may happen to it.

    `parameters`, `send` and `close` are every peer's. The rest is for the capabilities that are
    declared.
    """

    def encode(self, payload: bytes) -> bytes:
        """The bytes that `send` sends for a payload."""
        ...

    def send_raw(self, data: bytes) -> None:
        """Sends bytes as they are: junk, a part of a frame. Of messages, one that may be none.

        Raises:
            TransportError: The link has been closed.
        """
        ...

    def unplug(self) -> None:
        """Takes the device away, as pulling the plug does."""
        ...

    def replug(self) -> None:
        """Brings it back, under the same name. Called after `unplug` only."""
        ...
