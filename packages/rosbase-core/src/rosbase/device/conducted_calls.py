"""The part that a recorded and a replayed transport share: both do the same with a frame."""

from abc import abstractmethod

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

__all__ = ["ConductedTransport"]


class ConductedTransport(Transport):
    """Its calls are sections, its frames are entries, and its health is a fact.

    Which `on_frame` takes frames changes only inside the program, so it changes at the same place
    in a replay.
    """

    def __init__(self, conductor: Conductor, name: str, context: TransportContext) -> None:
        self._conductor = conductor
        self._logger = context.logger
        self._on_frame: OnFrame | None = None
        self._number = conductor.number(Numbered.TRANSPORT, name, self._play)

    def open(self) -> None:
        """Open the device."""
        self._section("open")

    def start(self, on_frame: OnFrame) -> None:
        """Start handing over frames; the first ones may come before this returns."""
        before = self._on_frame
        if before is None:
            self._on_frame = on_frame
        try:
            self._section("start")
        except BaseException:
            self._on_frame = before
            raise

    def stop(self) -> None:
        """Stop reading. Frames that the reader has handed over by then still come in."""
        try:
            self._section("stop")
        finally:
            self._on_frame = None

    def close(self) -> None:
        """Stop, and release the device."""
        try:
            self._section("close")
        finally:
            self._on_frame = None

    @property
    def is_open(self) -> bool:
        """Whether the device is open at this moment."""
        return bool(self._conductor.fact(self._is_open_now))

    @property
    def health(self) -> TransportHealth:
        """Health of the transport."""
        return health_from_json(self._conductor.fact(lambda: health_to_json(self._health_now())))

    def _take(self, frame: bytes, stamp_ns: int) -> bool | None:
        """Hand a frame to the program. Call it inside."""
        on_frame = self._on_frame
        return None if on_frame is None else hand_over(on_frame, frame, stamp_ns, self._logger)

    def _play(self, entry: Entry) -> None:
        """Hand the frame of a recording to the program."""
        self._take(entry.payload, entry.ints[2])

    def _section(self, op: str) -> None:
        self._conductor.section(self._number, op, lambda: self._call(op))

    @abstractmethod
    def _call(self, op: str) -> None:
        """Make one of `SECTION_OPS`, with the turn free. A replay never does."""

    @abstractmethod
    def _is_open_now(self) -> bool:
        """Return whether the device is open, for a fact."""

    @abstractmethod
    def _health_now(self) -> TransportHealth:
        """Return the health, for a fact."""
