"""The part that a recorded and a replayed transport share: both do the same with a frame."""

from abc import abstractmethod
from threading import get_ident

from rosbase.contracts.transport import (
    OnFrame,
    Transport,
    TransportContext,
    TransportHealth,
    hand_over,
)
from rosbase.device.health_json import health_from_json, health_to_json
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Numbered
from rosbase.entries.script import Entry

__all__ = ["ConductedTransport", "Reading"]

_NOBODY = 0


class Reading:
    """The frames from one `start` on, which go to its `on_frame`.

    It has a number of its own: only the transport knows whether a `start` has any effect.
    """

    __slots__ = ("is_over", "number", "on_frame")

    def __init__(self, on_frame: OnFrame) -> None:
        self.on_frame = on_frame
        self.number = -1
        self.is_over = False


class ConductedTransport(Transport):
    """Its calls are sections, its frames are entries, and its health is a fact.

    Readings begin and end only inside the program, so they do so at the same place in a replay.
    """

    def __init__(self, conductor: Conductor, name: str, context: TransportContext) -> None:
        self._conductor = conductor
        self._name = name
        self._logger = context.logger
        # Those since the last stop, though at most one of them has frames.
        self._readings: tuple[Reading, ...] = ()
        # The thread on which `on_frame` runs.
        self._thread = _NOBODY
        self._number = conductor.number(Numbered.TRANSPORT, name, lambda _: None)

    def open(self) -> None:
        """Open the device."""
        if not self._is_within:
            self._section("open")

    def start(self, on_frame: OnFrame) -> None:
        """Start handing over frames; the first ones may come before this returns."""
        if self._is_within:
            return
        reading = Reading(on_frame)
        reading.number = self._conductor.number(
            Numbered.TRANSPORT,
            f"{self._name}.start",
            lambda entry: self._play(reading, entry),
        )
        self._section("start", reading)
        self._readings = (*self._readings, reading)

    def stop(self) -> None:
        """Stop reading. Frames that the reader has handed over by then come in before it ends."""
        self._end("stop")

    def close(self) -> None:
        """Stop, and release the device."""
        self._end("close")

    @property
    def is_open(self) -> bool:
        """Whether the device is open at this moment."""
        return bool(self._conductor.fact(self._is_open_now))

    @property
    def health(self) -> TransportHealth:
        """Health of the transport."""
        return health_from_json(self._conductor.fact(lambda: health_to_json(self._health_now())))

    def _end(self, op: str) -> None:
        # Without the calls of another thread that starts it meanwhile.
        ending = self._readings
        try:
            self._section(op)
        finally:
            for reading in ending:
                reading.is_over = True
            self._readings = tuple(one for one in self._readings if one not in ending)

    def _take(self, reading: Reading, frame: bytes, stamp_ns: int) -> bool | None:
        """Hand a frame to the program. Call it inside."""
        if reading.is_over:
            return None
        before, self._thread = self._thread, get_ident()
        try:
            return hand_over(reading.on_frame, frame, stamp_ns, self._logger)
        finally:
            self._thread = before

    def _play(self, reading: Reading, entry: Entry) -> None:
        """Hand the frame of a recording to the program."""
        self._take(reading, entry.payload, entry.ints[2])

    @property
    def _is_within(self) -> bool:
        """Whether `on_frame` makes this call, on whichever thread it runs: it has no effect."""
        return self._thread == get_ident()

    def _section(self, op: str, reading: Reading | None = None) -> None:
        if not self._conductor.is_inside:
            self._conductor.spoil(f"a thread of the program's own calls {op} of a transport")
        self._conductor.section(self._number, op, lambda: self._call(op, reading))

    @abstractmethod
    def _call(self, op: str, reading: Reading | None) -> None:
        """Make one of `SECTION_OPS`, with the turn free. A replay never does.

        Args:
            op: The call.
            reading: Takes the frames of a `start`.
        """

    @abstractmethod
    def _is_open_now(self) -> bool:
        """Return whether the device is open, for a fact."""

    @abstractmethod
    def _health_now(self) -> TransportHealth:
        """Return the health, for a fact."""
