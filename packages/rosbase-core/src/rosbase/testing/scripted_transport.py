"""A transport whose device is the test."""

from collections.abc import Mapping

from rosbase.contracts.transport import (
    OnFrame,
    Transport,
    TransportContext,
    TransportHealth,
    TransportState,
)
from rosbase.errors import TransportError
from rosbase.parameters import ParameterValue

__all__ = ["ScriptedTransport"]


class ScriptedTransport(Transport):
    """Hands over what the test gives it, on the test's thread, and notes the calls.

    A plugin for a test makes it of the same arguments as any transport.
    """

    def __init__(self, values: Mapping[str, ParameterValue], context: TransportContext) -> None:
        """Is closed."""
        self.values = values
        """The parameters that it was made with."""
        self.context = context
        self.calls: list[str] = []
        """The names of the four calls, in their order."""
        self.failure: TransportError | None = None
        """What `open` raises, if anything."""
        self.frame_errors: dict[str, int] = {}
        """What health is to report."""
        self.state = TransportState.CLOSED
        """What health is to report; `open` and `close` set it."""
        self.last_data_ns: int | None = None
        """What health is to report; `deliver` sets it."""
        self.pending_bytes = 0
        """What health is to report."""
        self._on_frame: OnFrame | None = None

    def open(self) -> None:
        """Is open from now on, or fails."""
        self.calls.append("open")
        if self.failure is not None:
            raise self.failure
        self.state = TransportState.CONNECTED

    def start(self, on_frame: OnFrame) -> None:
        """Hands over from now on."""
        self.calls.append("start")
        self._on_frame = on_frame

    def stop(self) -> None:
        """Hands over no more."""
        self.calls.append("stop")
        self._on_frame = None

    def close(self) -> None:
        """Is closed from now on."""
        self.calls.append("close")
        self._on_frame = None
        self.state = TransportState.CLOSED

    @property
    def is_open(self) -> bool:
        """Whether its state says so."""
        return self.state is TransportState.CONNECTED

    @property
    def health(self) -> TransportHealth:
        """What the test has set."""
        return TransportHealth(
            state=self.state,
            frame_errors=self.frame_errors,
            last_data_ns=self.last_data_ns,
            last_error=str(self.failure or ""),
            pending_bytes=self.pending_bytes,
        )

    def deliver(self, frame: bytes, stamp_ns: int = 0) -> bool | None:
        """Hand one frame over; return the answer of `on_frame`.

        Raises:
            RuntimeError: It has not been started.
        """
        if self._on_frame is None:
            raise RuntimeError("the transport has not been started")
        self.last_data_ns = self.context.clock.monotonic_ns()
        return self._on_frame(frame, stamp_ns)
