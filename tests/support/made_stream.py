"""A stream of frames on clocks that a test turns, and the stamps that its reader gives."""

from typing import NamedTuple

from rosbase.stamps import Rhythm, Timeline
from support.strategies import MadeRead

__all__ = ["BEGINNING_NS", "MadeStream", "Stamped"]

BEGINNING_NS = 1_700_000_000_000_000_000


class Stamped(NamedTuple):
    """The stamps of one read, and what bounds them; all dates are those after the read."""

    stamps: list[int | None]
    """In the order of the frames."""
    carried: int
    """How many of the frames had begun in an earlier read: none or one."""
    begun_ns: int
    """The date of the read in which that one had begun."""
    begun_at_ns: int
    """The monotonic time of that read."""
    looked_ns: int
    """The date of the last look before the read."""
    date_ns: int
    """The date of the read."""
    at_ns: int
    """The monotonic time of the read."""
    usual_ns: int
    """The usual interval, as it was known before the read."""
    step_ns: int
    """By how much the reader was told that the date has been set."""


class MadeStream:
    """A reader on made clocks: `read` is one of its reads."""

    def __init__(self) -> None:
        self.rhythm = Rhythm()
        self.timeline = Timeline(self.rhythm)
        self.at_ns = 0
        self.offset_ns = BEGINNING_NS
        self._begun_ns: int | None = None
        self.timeline.begin(0)

    def read(self, made: MadeRead) -> Stamped:
        looked_ns = self._pass(made)
        before_ns = self.at_ns
        date_ns = before_ns + made.held_ns[0] + self.offset_ns
        self.at_ns += sum(made.held_ns)
        self.timeline.read(date_ns, self.at_ns)
        begun = [self.at_ns] * made.frames
        carried = 0
        begun_ns, begun_here = self._begun_ns or 0, bool(made.begins)
        if self._begun_ns is not None and made.frames:
            begun[0], carried = self._begun_ns, 1
            self._begun_ns = None
        # What has begun stays begun until some frame is completed.
        if begun_here and self._begun_ns is None:
            self._begun_ns = self.at_ns
        usual_ns = self.rhythm.interval_ns
        step_ns, stamps = self._stamps(begun, made.held_ns[0], is_within=self._begun_ns is not None)
        stamped = Stamped(
            stamps,
            carried,
            begun_ns + self.offset_ns,
            begun_ns,
            looked_ns + self.offset_ns,
            self.at_ns + self.offset_ns,
            self.at_ns,
            usual_ns,
            step_ns,
        )
        self.at_ns += 1_000
        return stamped

    def _pass(self, made: MadeRead) -> int:
        """Lets the pause go by; gives the time of the last look in it."""
        looked_ns = self.at_ns - 1_000 if self.at_ns else 0
        self.at_ns += made.pause_ns
        self.offset_ns += made.step_ns
        if made.looks:
            looked_ns = self.at_ns - made.pause_ns // 4
            self.timeline.look(looked_ns)
        return looked_ns

    def _stamps(
        self, begun: list[int], held_ns: int, *, is_within: bool
    ) -> tuple[int, list[int | None]]:
        """What the date was set by, as far as it is seen, and the stamps."""
        if not begun:
            return 0, []
        if len(begun) == 1 and (begun[0] < self.at_ns or not is_within):
            stamp_ns = self.timeline.one(begun[0])
            if stamp_ns is not None:
                return 0, [stamp_ns]
        step_ns = 0
        if self.timeline.may_be_set:
            before_ns, date_ns = self.at_ns, self.at_ns + self.offset_ns
            # Somebody else may have had the processor once more.
            step_ns = self.timeline.step(before_ns, date_ns + held_ns // 2, before_ns + held_ns)
        return step_ns, self.timeline.many(begun, is_within=is_within)
