"""Transport that the test controls."""

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
    """Transport that delivers the frames of a test, on the test's thread, and records the calls.

    The plugin of a test makes it with the same arguments as any transport.
    """

    def __init__(self, values: Mapping[str, ParameterValue], context: TransportContext) -> None:
        """Start closed."""
        self.values = values
        """Parameters that it was made with."""
        self.context = context
        self.calls: list[str] = []
        """Names of the four calls, in their order."""
        self.failure: TransportError | None = None
        """Exception that `open` raises, if any."""
        self.frame_errors: dict[str, int] = {}
        """Frame errors in health."""
        self.state = TransportState.CLOSED
        """State in health; `open` and `close` set it."""
        self.last_data_ns: int | None = None
        """Time of the last data in health; `deliver` sets it."""
        self.pending_bytes = 0
        """Pending bytes in health."""
        self._on_frame: OnFrame | None = None

    def open(self) -> None:
        """Open the transport, or fail."""
        self.calls.append("open")
        if self.failure is not None:
            raise self.failure
        self.state = TransportState.CONNECTED

    def start(self, on_frame: OnFrame) -> None:
        """Start to deliver frames."""
        self.calls.append("start")
        self._on_frame = on_frame

    def stop(self) -> None:
        """Stop delivering frames."""
        self.calls.append("stop")
        self._on_frame = None

    def close(self) -> None:
        """Close the transport."""
        self.calls.append("close")
        self._on_frame = None
        self.state = TransportState.CLOSED

    @property
    def is_open(self) -> bool:
        """Whether the state is CONNECTED."""
        return self.state is TransportState.CONNECTED

    @property
    def health(self) -> TransportHealth:
        """Health with the values that the test has set."""
        return TransportHealth(
            state=self.state,
            frame_errors=self.frame_errors,
            last_data_ns=self.last_data_ns,
            last_error=str(self.failure or ""),
            pending_bytes=self.pending_bytes,
        )

    def deliver(self, frame: bytes, stamp_ns: int = 0) -> bool | None:
        """Deliver one frame; return the answer of `on_frame`.

        Raises:
            RuntimeError: The transport has not been started.
        """
        if self._on_frame is None:
            raise RuntimeError("the transport has not been started")
        self.last_data_ns = self.context.clock.monotonic_ns()
        return self._on_frame(frame, stamp_ns)
