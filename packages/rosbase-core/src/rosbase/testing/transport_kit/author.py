"""Definitions by the author of a transport: how to make one, and a peer for it."""

from typing import ClassVar

from rosbase.contracts.transport import SimulatedDevice, Transport, TransportContext
from rosbase.plugins import TransportPlugin, installed_plugins
from rosbase.testing.transport_kit.capabilities import TransportCapabilities
from rosbase.testing.transport_kit.promises import FACTORY, PEER

__all__ = ["TransportAuthor"]

_SAMPLE = (
    b'{"angular_velocity":{"x":0.01,"y":-0.02,"z":0.5},'
    b'"linear_acceleration":{"x":0.1,"y":-0.2,"z":9.81},"number":%d}'
)


class TransportAuthor:
    """Definitions by the author. Must define: `transport`, or `make_peer` and `make_transport`.

    May define: the capabilities, the payloads, the limits. Do not override the checks.
    """

    transport: ClassVar[str] = ""
    """Name of an installed transport, as in `comm_t`."""
    capabilities: ClassVar[TransportCapabilities] = TransportCapabilities()
    """Optional capabilities of the transport."""
    payloads: ClassVar[tuple[bytes, ...]] = (
        b"0",
        b'{"text": "two  blanks"}',
        '{"text": "größer"}'.encode(),
        b"\x01\xfe\xff\x80",
        b"x" * 3_000,
        b"y" * 20_000,
    )
    """Unusual payloads that the transport can carry."""
    junk: ClassVar[tuple[bytes, ...]] = (
        b"\x00\x00ets Jul 29 2019 12:21:46 rst:0x1 (POWERON_RESET)",
        b'"z":9.81}}',
        bytes(range(256)),
        b"\xff" * 1_000,
        b"x" * 200_000,
    )
    """Bytes that may arrive on a stream between two frames."""
    endless: ClassVar[bytes] = b"x" * 65_536
    """Bytes that arrive repeatedly and never end a frame."""

    call_limit_s: ClassVar[float] = 5.0
    """Limit of `open` and `start`, in seconds; also of the others while `on_frame` hangs."""
    end_limit_s: ClassVar[float] = 1.0
    """Limit of `stop` and `close`, in seconds."""
    patience_s: ClassVar[float] = 5.0
    """Timeout for expected events, such as the arrival of a frame, in seconds."""
    reconnect_limit_s: ClassVar[float] = 5.0
    """Limit until data flows again after the device is back, in seconds."""
    stamp_limit_s: ClassVar[float] = 0.015
    """Limit from sending a frame to its stamp, in seconds, on an idle machine."""
    memory_limit_bytes: ClassVar[int] = 1_000_000
    """Maximum memory of a transport, in bytes, while four times as much arrives."""
    cycles: ClassVar[int] = 10
    """Number of repetitions of the checks for leaks."""
    machine_examples: ClassVar[int] = 100
    """Number of histories that the state machine tries."""
    machine_steps: ClassVar[int] = 15
    """Number of steps of each history."""

    def make_peer(self) -> SimulatedDevice:
        """Return a new simulated device. By default the plugin's `simulate` opens it."""
        simulate = self.plugin().simulate
        if simulate is None:
            raise PEER.broken(
                f"the transport '{self.transport}' has no simulated device: "
                "give its TransportPlugin a `simulate`, or write make_peer"
            )
        return simulate()

    def make_transport(self, peer: SimulatedDevice, context: TransportContext) -> Transport:
        """Make a transport that reads the peer, from the peer's `parameters`."""
        plugin = self.plugin()
        values = {spec.name: spec.default for spec in plugin.parameters}
        return plugin.create(values | dict(peer.parameters), context)

    def payload(self, number: int) -> bytes:
        """Return a typical payload, a different one for each number from 0 to 9999."""
        return _SAMPLE % number

    def plugin(self) -> TransportPlugin:
        """Return the plugin of the installed transport, if `transport` names one."""
        FACTORY.require(
            self.transport,
            f"{type(self).__name__} names no installed transport and does not write "
            "make_peer and make_transport: set `transport`, or write both",
        )
        return installed_plugins().transport(self.transport)
