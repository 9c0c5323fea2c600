"""The transport contract: where the frames of a device come from.

Must implement: every abstract method and property. Nothing else is called, so there is
nothing to override.

`open`, `start`, `stop` and `close` may be called from any thread, also from `on_frame`, in
any order and any number of times; each returns within seconds whatever the device does.
Coming back after the device was lost is the transport's duty. That a device is alive is
known by one thing only: that data arrived.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Protocol, TypeAlias

from attrs import define, field, frozen

from rosbase.clock import Clock
from rosbase.logger import RosbaseLogger
from rosbase.parameters import ParameterValue

__all__ = [
    "OnFrame",
    "SimulatedDevice",
    "Tally",
    "Transport",
    "TransportContext",
    "TransportHealth",
    "TransportState",
    "hand_over",
]

_CALLBACK_LOG_S = 5.0

OnFrame: TypeAlias = Callable[[bytes, int], object]
"""`on_frame(frame, stamp_ns)`: one whole frame, and when its first bytes were read."""


class TransportState(Enum):
    """What a transport is doing."""

    CLOSED = "closed"
    CONNECTED = "connected"
    RECONNECTING = "reconnecting"
    """The device is absent or was lost; the transport keeps trying."""


@frozen
class TransportHealth:
    """How a transport has been doing since it was made."""

    state: TransportState = TransportState.CLOSED
    frames: int = 0
    """Frames handed over."""
    received_bytes: int = 0
    frame_errors: Mapping[str, int] = field(factory=dict)
    """What could not become a frame, counted by reason."""
    reconnects: int = 0
    """How often the device was lost and came back."""
    last_data_ns: int | None = None
    """When bytes last arrived, on the monotonic clock; None if none ever did."""
    last_error: str = ""
    """Why the device could not be opened or was lost, the last time; one line."""


@define
class Tally:
    """What a transport has counted so far. One thread writes; any thread may read."""

    frames: int = 0
    received_bytes: int = 0
    frame_errors: dict[str, int] = field(factory=dict)
    reconnects: int = 0
    last_data_ns: int | None = None
    last_error: str = ""

    def count_error(self, reason: str) -> None:
        """Counts something that could not become a frame."""
        self.frame_errors[reason] = self.frame_errors.get(reason, 0) + 1

    def health(self, state: TransportState) -> TransportHealth:
        """All of it, at this moment."""
        return TransportHealth(
            state,
            self.frames,
            self.received_bytes,
            # In one step, because the other thread may be counting.
            dict(self.frame_errors),
            self.reconnects,
            self.last_data_ns,
            self.last_error,
        )


@frozen
class TransportContext:
    """What a transport is given beside its parameters."""

    clock: Clock
    logger: RosbaseLogger


def hand_over(on_frame: OnFrame, frame: bytes, stamp_ns: int, logger: RosbaseLogger) -> None:
    """Calls `on_frame`. What that raises is logged, at a limited rate: the stream goes on."""
    try:
        on_frame(frame, stamp_ns)
    except BaseException as error:
        # The boundary to the user's code. Base: one that calls sys.exit() would end the thread
        # only, in silence.
        if logger.due("on_frame", _CALLBACK_LOG_S):
            logger.error(f"on_frame raised {error!r}", exc_info=error)


class Transport(ABC):
    """Reads frames from a device and hands them over, one by one, on a thread of its own."""

    @abstractmethod
    def open(self) -> None:
        """Takes the device. Does nothing if it is open.

        A transport that was told to wait for its device returns without it, and takes it
        when it comes, once started.

        Raises:
            TransportError: The device cannot be had; the subclass and the one line say why.
        """

    @abstractmethod
    def start(self, on_frame: OnFrame) -> None:
        """Starts handing over the frames that arrive from now on, on the reader thread.

        What the device sent before is discarded: it is not known when. An exception from
        `on_frame` is logged, and reading goes on. Does nothing if the reader runs.

        Raises:
            TransportError: The transport is not open, and opening it failed.
        """

    @abstractmethod
    def stop(self) -> None:
        """Ends the reader thread. When it returns, `on_frame` is not called again.

        The exceptions: from within `on_frame` the thread ends after that call; and if
        `on_frame` itself does not return in time, it is left behind and ends with it.
        """

    @abstractmethod
    def close(self) -> None:
        """Stops, and releases the device."""

    @property
    @abstractmethod
    def is_open(self) -> bool:
        """Whether the device is held at this moment."""

    @property
    @abstractmethod
    def health(self) -> TransportHealth:
        """How it is doing; from any thread, without waiting."""


class SimulatedDevice(Protocol):
    """A stand-in at the far end of a real link, for demos and tests."""

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """What the transport must be given to reach this device."""
        ...

    def send(self, payload: bytes) -> None:
        """Sends one payload as a device does, delimiter included. Waits while the link is full.

        Raises:
            TransportError: The link has been closed.
        """
        ...

    def close(self) -> None:
        """Ends the link, as pulling the plug does. A `send` that waits ends. Idempotent."""
        ...
