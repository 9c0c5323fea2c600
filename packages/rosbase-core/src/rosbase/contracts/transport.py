"""The transport contract: where the frames of a device come from.

Must implement: `open`, `start`, `stop`, `close`, `is_open` and `health`. May implement: nothing
more; nothing else is called. Never override: there is nothing of a base class to override, and
whoever builds on `rosbase.device.DeviceTransport` overrides none of it.

All six may be called from any thread, in any order and any number of times. The four calls may
come from within `on_frame`: there `open` and `start` do nothing, and `stop` and `close` take
effect when that call has returned. Only `TransportError` is raised, by `open` and `start` only.
`open` and `start` return within 5 seconds, `stop` and `close` within one, whatever the device
does; within 5 if `on_frame` does not return. `is_open` and `health` never wait.

Coming back after the device was lost is the transport's duty, as long as it is started. That a
device is alive is known by one thing only: that data arrived. What a transport does for itself
while it is stopped, and its state then when the device is away, is its own affair.

`on_frame` answers whether a sample came of the frame. Arrival proves that a device is alive, and a
sample proves that it is the right one: a transport with a choice between sources, such as the
topics under a wildcard, chooses by the answer. Nothing else depends on it: whatever `on_frame`
answers or raises, the next frame is handed over.

Dates and monotonic times are those of the context's clock. The log says each change in a line,
and nothing of each try. `Tally` counts and `hand_over` calls `on_frame` as promised here.
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
"""`on_frame(frame, stamp_ns)`: take one frame, stamped when its first bytes were read.

Return whether a sample came of it. None means that the callback does not know.
"""


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
    """Why the device could not be opened or was lost, the last time; one line.

    Or what is wrong with it while it is read. Empty if nothing of that happened, or once the
    device is back and has proved to stay.
    """
    pending_bytes: int = 0
    """Bytes that arrived since the last end of a frame, as far as the transport knows."""
    interval_ns: int = 0
    """The usual time between two frames; 0 while it is not known."""
    jitter_ns: int = 0
    """How far from the usual interval frames arrive, on average."""
    clock_steps: int = 0
    """How often the date was set while frames came."""
    late_frames: int = 0
    """Frames that waited for more than a second, because nobody read.

    Those among them that nobody can date are not handed over: they are in `frame_errors` too, as
    `late`.
    """
    link_errors: Mapping[str, int] = field(factory=dict)
    """Bytes that were lost or damaged on the way, by reason, as far as the device counts them.

    `framing_error` means bytes as if sent at another rate.
    """


@define
class Tally:
    """What a transport has counted so far. One thread writes; any thread may read."""

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
        """Counts something that could not become a frame.

        A reason is a word of the transport's own. Of more than a hundred different ones, the
        others are counted as `other`.
        """
        if reason not in self.frame_errors and len(self.frame_errors) >= _MOST_REASONS:
            reason = "other"
        self.frame_errors[reason] = self.frame_errors.get(reason, 0) + 1

    def count_link_errors(self, errors: Mapping[str, int]) -> None:
        """Count what went wrong on the way here: how often, by reason."""
        for reason, number in errors.items():
            self.link_errors[reason] = self.link_errors.get(reason, 0) + number

    def health(self, state: TransportState, pending_bytes: int = 0) -> TransportHealth:
        """Return all of it, at this moment.

        Args:
            state: What the transport is doing.
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
    """What a transport is given beside its parameters."""

    clock: Clock
    logger: RosbaseLogger
    stale_timeout_s: float = 1.0
    """Seconds without a sample after which a device counts as silent: the reader's parameter."""
    frames_are_dated: bool = False
    """Whether frames carry dates of their own, so that none is dropped because it came late."""


def hand_over(on_frame: OnFrame, frame: bytes, stamp_ns: int, logger: RosbaseLogger) -> bool:
    """Call `on_frame`; log what it raises, at a limited rate.

    Returns:
        Whether a sample came of the frame. An answer that is no bool, such as None, counts as
        yes: a program that does not know is served as if every frame were a sample. A call that
        raises counts as no.
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
    """Reads frames from a device and hands them over, one by one, on a thread of its own."""

    @abstractmethod
    def open(self) -> None:
        """Takes the device. Does nothing if it is open.

        May wait for the device to answer, 5 seconds at most. A transport that was told to wait
        for a device that is absent returns without it, and takes it when it comes, once started.

        Raises:
            TransportError: The device cannot be had; the subclass says which kind of reason it
                is, the one line names the device. It may be tried again.
        """

    @abstractmethod
    def start(self, on_frame: OnFrame) -> None:
        """Starts handing over the frames that arrive from now on, on the reader thread.

        Opens the device if it is not open. What the device sent before is discarded: it is not
        known when. What it sends once `start` has returned is handed over. An exception from
        `on_frame` is logged, and reading goes on, as it does after any answer. Does nothing if
        the reader runs: whoever wants another `on_frame` stops it first.

        Raises:
            TransportError: The transport is not open, and opening it failed; or the system has
                no more threads or descriptors.
        """

    @abstractmethod
    def stop(self) -> None:
        """Ends the reading and keeps the device. When it returns, `on_frame` is not called again.

        Waits for an `on_frame` that runs. The exceptions: from within `on_frame` the reading ends
        after that call; and an `on_frame` that does not return for some seconds is left behind
        with its thread, which ends with it.
        """

    @abstractmethod
    def close(self) -> None:
        """Stops, and releases the device, with every thread and descriptor."""

    @property
    @abstractmethod
    def is_open(self) -> bool:
        """Whether the device is held at this moment; without waiting."""

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

        When it returns, the payload is with whoever reads at that moment, or on its way there.

        Raises:
            TransportError: The link has been closed.
        """
        ...

    def close(self) -> None:
        """Ends the link, as pulling the plug does. A `send` that waits ends. Idempotent."""
        ...


@runtime_checkable
class PluggableDevice(SimulatedDevice, Protocol):
    """A simulated device with a plug that can be pulled and put back, for `rosbase demo`.

    It is plugged in when it is made. While it is not, `send` raises TransportError.
    """

    @property
    def has_room(self) -> bool:
        """Whether the link would take a payload now, without waiting for whoever reads."""
        ...

    def unplug(self) -> None:
        """Pull the plug: whoever reads loses the device. Idempotent."""
        ...

    def replug(self) -> None:
        """Put the plug back: the device is where it was, by the same parameters. Idempotent."""
        ...
