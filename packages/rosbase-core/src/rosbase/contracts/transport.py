"""The transport contract: reads the frames of a device and hands them over.

Must implement: `open`, `start`, `stop`, `close`, `is_open` and `health`. Nothing else is called.
Never override the methods of `rosbase.device.DeviceTransport` if you build on it.

All six may be called from any thread, in any order and any number of times. The four calls may
also be made within `on_frame`. There `open` and `start` do nothing, and `stop` and `close` take
effect when that call has returned. Only `open` and `start` raise, and only `TransportError`.
`open` and `start` return within 5 seconds, and `stop` and `close` within one, whatever the device
does. If `on_frame` does not return, they return within 5. `is_open` and `health` never wait.

The transport must reconnect after the device was lost, as long as it is started. Only arriving
data proves that a device is alive. While a transport is stopped, it may do as it likes, and show
any state when the device is away.

`on_frame` returns whether the frame gave a sample. Arrival proves that a device is alive, and a
sample proves that it is the right one. A transport that must choose between sources, such as the
topics under a wildcard, uses the answer. Nothing else depends on it: whatever `on_frame` returns
or raises, the next frame is handed over.

Dates and monotonic times come from the context's clock. The log has one line for each change, and
none for each try. `Tally` counts and `hand_over` calls `on_frame` as promised here.
`rosbase.testing.TransportContract` checks all of it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Protocol, TypeAlias, runtime_checkable

from attrs import define, field, frozen

from rosbase.clock import Clock
from rosbase.logger import RosbaseLogger
from rosbase.parameters import ParameterValue
from rosbase.stamps import Rhythm

__all__ = [
    "OnFrame",
    "PluggableDevice",
    "SimulatedDevice",
    "Tally",
    "Transport",
    "TransportContext",
    "TransportHealth",
    "TransportState",
    "hand_over",
]

_CALLBACK_LOG_S = 5.0
_MOST_REASONS = 100

OnFrame: TypeAlias = Callable[[bytes, int], bool | None]
"""`on_frame(frame, stamp_ns)`: takes one frame, stamped when its first bytes were read.

It returns whether the frame gave a sample. None means that the callback does not know.
"""


class TransportState(Enum):
    """State of a transport."""

    CLOSED = "closed"
    CONNECTED = "connected"
    RECONNECTING = "reconnecting"
    """The device is absent or was lost; the transport keeps trying."""


@frozen
class TransportHealth:
    """Health of a transport since it was made."""

    state: TransportState = TransportState.CLOSED
    frames: int = 0
    """Number of frames handed over."""
    received_bytes: int = 0
    frame_errors: Mapping[str, int] = field(factory=dict)
    """Data that could not become a frame, counted by reason."""
    reconnects: int = 0
    """Number of times that the device was lost and came back."""
    last_data_ns: int | None = None
    """Monotonic time at which bytes last arrived; None if none ever did."""
    last_error: str = ""
    """Last reason why the device could not be opened or was lost; one line.

    A fault of the device while it is read is shown too. Empty if nothing of that happened, or
    once the device is back and has proved to stay.
    """
    pending_bytes: int = 0
    """Bytes that arrived since the last end of a frame, as far as the transport knows."""
    interval_ns: int = 0
    """Usual time between two frames; 0 while it is not known."""
    jitter_ns: int = 0
    """Average deviation of frames from the usual interval."""
    clock_steps: int = 0
    """Number of times that the date was set while frames came."""
    late_frames: int = 0
    """Number of frames that waited for more than a second, because nobody read.

    Frames among them that nobody can date are not handed over. They also count in
    `frame_errors`, as `late`.
    """
    link_errors: Mapping[str, int] = field(factory=dict)
    """Bytes lost or damaged on the way, by reason, as far as the device counts them.

    `framing_error` means bytes as if sent at another rate.
    """


@define
class Tally:
    """Counts of a transport so far. One thread writes; any thread may read."""

    frames: int = 0
    received_bytes: int = 0
    frame_errors: dict[str, int] = field(factory=dict)
    reconnects: int = 0
    last_data_ns: int | None = None
    last_error: str = ""
    clock_steps: int = 0
    late_frames: int = 0
    rhythm: Rhythm = field(factory=Rhythm)
    link_errors: dict[str, int] = field(factory=dict)

    def count_error(self, reason: str) -> None:
        """Count data that could not become a frame.

        The transport chooses the word for a reason. After a hundred different ones, new
        reasons count as `other`.
        """
        if reason not in self.frame_errors and len(self.frame_errors) >= _MOST_REASONS:
            reason = "other"
        self.frame_errors[reason] = self.frame_errors.get(reason, 0) + 1

    def count_link_errors(self, errors: Mapping[str, int]) -> None:
        """Count transmission errors, by reason."""
        for reason, number in errors.items():
            self.link_errors[reason] = self.link_errors.get(reason, 0) + number

    def health(self, state: TransportState, pending_bytes: int = 0) -> TransportHealth:
        """Return the counts as they are now.

        Args:
            state: State of the transport.
            pending_bytes: Bytes that arrived since the last end of a frame.
        """
        return TransportHealth(
            state,
            self.frames,
            self.received_bytes,
            # In one step, because the other thread may be counting.
            dict(self.frame_errors),
            self.reconnects,
            self.last_data_ns,
            self.last_error,
            pending_bytes,
            self.rhythm.interval_ns,
            self.rhythm.jitter_ns,
            self.clock_steps,
            self.late_frames,
            dict(self.link_errors),
        )


@frozen
class TransportContext:
    """Context that a transport receives beside its parameters."""

    clock: Clock
    logger: RosbaseLogger
    stale_timeout_s: float = 1.0
    """Seconds without a sample after which a device counts as silent.

    This is the reader's parameter.
    """
    frames_are_dated: bool = False
    """Whether frames carry their own dates, so that no frame is dropped for being late."""


def hand_over(on_frame: OnFrame, frame: bytes, stamp_ns: int, logger: RosbaseLogger) -> bool:
    """Call `on_frame`; log its exceptions, at a limited rate.

    Returns:
        Whether the frame gave a sample. An answer that is not a bool, such as None, counts as a
        yes. So a program that does not know is treated as if every frame gave a sample. A call
        that raises counts as a no.
    """
    try:
        return on_frame(frame, stamp_ns) is not False
    except BaseException as error:
        # The boundary to the user's code. Base: one that calls sys.exit() would end the thread
        # only, in silence.
        if logger.due("on_frame", _CALLBACK_LOG_S):
            logger.error(f"on_frame raised {error!r}", exc_info=error)
        return False


class Transport(ABC):
    """Reads frames from a device and hands them over, one by one, on its own thread."""

    @abstractmethod
    def open(self) -> None:
        """Open the device. Do nothing if it is open.

        This may wait for the device to answer, 5 seconds at most. A transport that was
        told to wait for an absent device returns without it. Once started, it opens the
        device when it comes.

        Raises:
            TransportError: The device cannot be opened. The subclass gives the kind of reason, and
                the one-line message names the device. You may try again.
        """

    @abstractmethod
    def start(self, on_frame: OnFrame) -> None:
        """Start handing over the frames that arrive from now on, on the reader thread.

        Opens the device if it is not open. Data from before `start` is discarded, because
        its time is unknown. Frames sent after `start` has returned are handed over. An
        exception from `on_frame` is logged, and reading goes on, as it does after any
        answer. Does nothing if the reader runs: to use another `on_frame`, stop it first.

        Raises:
            TransportError: The transport is not open, and opening it failed; or the system has
                no more threads or descriptors.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop reading and keep the device. After it returns, `on_frame` is not called again.

        Waits for an `on_frame` that runs. There are two exceptions. If you call it within
        `on_frame`, reading ends after that call. An `on_frame` that does not return for
        some seconds is left behind with its thread, which ends with it.
        """

    @abstractmethod
    def close(self) -> None:
        """Stop, and release the device with every thread and descriptor."""

    @property
    @abstractmethod
    def is_open(self) -> bool:
        """Whether the device is open at this moment; never waits."""

    @property
    @abstractmethod
    def health(self) -> TransportHealth:
        """Health of the transport; from any thread, never waits."""


class SimulatedDevice(Protocol):
    """A simulated device at the far end of a real link, for demos and tests."""

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """Parameters with which a transport reaches this device."""
        ...

    def send(self, payload: bytes) -> None:
        """Send one payload as a device does, delimiter included. Wait while the link is full.

        When it returns, the payload has been read or is on its way to the current reader.

        Raises:
            TransportError: The link has been closed.
        """
        ...

    def close(self) -> None:
        """End the link, as pulling the plug does. A `send` that waits ends. Idempotent."""
        ...


@runtime_checkable
class PluggableDevice(SimulatedDevice, Protocol):
    """A simulated device with a plug that can be pulled and put back, for `rosbase demo`.

    It is plugged in when it is made. While it is not, `send` raises TransportError.
    """

    @property
    def has_room(self) -> bool:
        """Whether the link would take a payload now, without waiting for the reader."""
        ...

    def unplug(self) -> None:
        """Pull the plug: the reader loses the device. Idempotent."""
        ...

    def replug(self) -> None:
        """Put the plug back: the device returns, with the same parameters. Idempotent."""
        ...
