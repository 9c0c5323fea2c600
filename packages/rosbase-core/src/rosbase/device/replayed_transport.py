"""A transport whose frames and results come from a recording."""

from attrs import evolve

from rosbase.contracts.transport import TransportContext, TransportHealth, TransportState
from rosbase.device.conducted_calls import ConductedTransport
from rosbase.entries.conductor import Conductor
from rosbase.entries.script import Entry

__all__ = ["ReplayedTransport"]


class ReplayedTransport(ConductedTransport):
    """Touches no device and no code of the plugin.

    If the program asks for its health more often than it did when it was recorded, the answer is
    the last recorded one, with the frames since.
    """

    def __init__(self, conductor: Conductor, name: str, context: TransportContext) -> None:
        """Start closed.

        Raises:
            ConfigurationError: The transport could not be made when this was recorded.
        """
        super().__init__(conductor, name, context)
        self._clock = getattr(conductor.clock, "machine", conductor.clock)
        self._is_open = False
        self._known = TransportHealth()
        self._section("create")

    @property
    def health(self) -> TransportHealth:
        """Health of the transport, as it was recorded."""
        self._known = super().health
        return self._known

    def _section(self, op: str) -> None:
        super()._section(op)
        self._is_open = op in ("open", "start") or (op == "stop" and self._is_open)
        state = TransportState.CONNECTED if self._is_open else TransportState.CLOSED
        self._known = evolve(self._known, state=state)

    def _play(self, entry: Entry) -> None:
        self._known = evolve(
            self._known,
            frames=self._known.frames + 1,
            received_bytes=self._known.received_bytes + len(entry.payload),
            last_data_ns=self._clock.monotonic_ns(),
        )
        super()._play(entry)

    def _call(self, op: str) -> None:
        raise AssertionError(f"a replay makes no call of a transport: {op}")

    def _is_open_now(self) -> bool:
        return self._is_open

    def _health_now(self) -> TransportHealth:
        return self._known
