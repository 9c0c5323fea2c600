"""What the author of a transport tells the kit: how to make one, and a peer for it."""

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
    """Must say: `transport`, or else `make_peer` and `make_transport`.

    May say: the capabilities, the payloads, the limits. The checks are not to be overridden.
    """

    transport: ClassVar[str] = ""
    """The name of an installed transport, as in `comm_t`."""
    capabilities: ClassVar[TransportCapabilities] = TransportCapabilities()
    """What the transport can do beside what all can."""
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
    """What may arrive on a stream between two frames."""
    endless: ClassVar[bytes] = b"x" * 65_536
    """What arrives again and again and never ends a frame."""

    call_limit_s: ClassVar[float] = 5.0
    """How long `open` and `start` may take, and the others while `on_frame` hangs."""
    end_limit_s: ClassVar[float] = 1.0
    """How long `stop` and `close` may take."""
    patience_s: ClassVar[float] = 5.0
    """How long what must happen is awaited, such as the arrival of a frame."""
    reconnect_limit_s: ClassVar[float] = 5.0
    """How long it may take until data flows again once the device is back."""
    stamp_limit_s: ClassVar[float] = 0.015
    """How long after it was sent a frame may be stamped, if the machine has nothing else to do."""
    memory_limit_bytes: ClassVar[int] = 1_000_000
    """How much memory a transport may use while four times as much arrives."""
    cycles: ClassVar[int] = 10
    """How often what must leak nothing is done."""
    machine_examples: ClassVar[int] = 100
    """How many histories the state machine tries."""
    machine_steps: ClassVar[int] = 15
    """How long each of them is."""

    def make_peer(self) -> SimulatedDevice:
        """Plays a device: a new one each time. By default what the plugin simulates."""
        simulate = self.plugin().simulate
        if simulate is None:
            raise PEER.broken(
                f"the transport '{self.transport}' has no simulated device: "
                "give its TransportPlugin a `simulate`, or write make_peer"
            )
        return simulate()

    def make_transport(self, peer: SimulatedDevice, context: TransportContext) -> Transport:
        """Makes a transport that reads the peer, of the peer's `parameters`."""
        plugin = self.plugin()
        values = {spec.name: spec.default for spec in plugin.parameters}
        return plugin.create(values | dict(peer.parameters), context)

    def payload(self, number: int) -> bytes:
        """A usual payload; another one for every number from 0 to 9999."""
        return _SAMPLE % number

    def plugin(self) -> TransportPlugin:
        """The installed transport, where `transport` names one."""
        FACTORY.require(
            self.transport,
            f"{type(self).__name__} names no installed transport and does not write "
            "make_peer and make_transport: set `transport`, or write both",
        )
        return installed_plugins().transport(self.transport)
