"""A transport whose frames and results come from a recording."""

from attrs import evolve

from rosbase.contracts.transport import TransportContext, TransportHealth, TransportState
from rosbase.device.conducted_calls import ConductedTransport, Reading
from rosbase.entries.conductor import Conductor
from rosbase.entries.script import Entry

__all__ = ["ReplayedTransport"]


class ReplayedTransport(ConductedTransport):
    """Touches no device and no code of the plugin.

    If the program asks for its health more often than it did when it was recorded, it gets the last
    recorded one, with the frames since.
    """

    def __init__(self, conductor: Conductor, name: str, context: TransportContext) -> None:
        """Start closed.

        Raises:
            ConfigurationError: The transport could not be made when this was recorded.
        """
        super().__init__(conductor, name, context)
        self._clock = getattr(conductor.clock, "machine", conductor.clock)
        self._state = TransportState.CLOSED
        self._known = TransportHealth()
        self._frames = self._bytes = 0
        self._section("create")

    @property
    def health(self) -> TransportHealth:
        """Health of the transport, as it was recorded."""
        try:
            self._known = super().health
        except ValueError:
            # A changed program asks for other facts, in another order.
            return self._health_now()
        self._frames = self._bytes = 0
        return self._known

    def _section(self, op: str, reading: Reading | None = None) -> None:
        super()._section(op, reading)
        if op in ("open", "start"):
            self._state = TransportState.CONNECTED
        elif op == "close":
            self._state = TransportState.CLOSED

    def _play(self, reading: Reading, entry: Entry) -> None:
        self._frames += 1
        self._bytes += len(entry.payload)
        self._last_ns = self._clock.monotonic_ns()
        super()._play(reading, entry)

    def _call(self, op: str, reading: Reading | None) -> None:
        raise AssertionError(f"a replay makes no call of a transport: {op}")

    def _is_open_now(self) -> bool:
        return self._state is TransportState.CONNECTED

    def _health_now(self) -> TransportHealth:
        known = evolve(self._known, state=self._state)
        if not self._frames:
            return known
        return evolve(
            known,
            frames=known.frames + self._frames,
            received_bytes=known.received_bytes + self._bytes,
            last_data_ns=self._last_ns,
        )
