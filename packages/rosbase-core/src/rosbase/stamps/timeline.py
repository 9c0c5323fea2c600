"""Stamps for the frames of one stream, from the moments at which it was read.

Stamps are computed on the monotonic clock, back from a read, and converted with the date of that
read. So a step of the date moves only later stamps.
"""

from collections.abc import Sequence

from rosbase.stamps.backlog import LATE_NS, dates, is_left_over, is_undatable
from rosbase.stamps.clock_offset import SLIGHT_NS, ClockOffset
from rosbase.stamps.rhythm import Rhythm

__all__ = ["Timeline"]

# A look that comes within this time, or within four usual intervals, is prompt.
_PROMPT_NS = 20_000_000
_PROMPT_SHIFT = 2
# What has waited is read within this time, or a quarter of the wait.
_DRAIN_NS, _DRAIN_SHIFT = 100_000_000, 2
# Once the rhythm is known, it is looked at after so many frames that came alone.
_FEW = 8
_NEVER_NS = -(1 << 62)


class Timeline:
    """Stamps frames in the order of their arrival. Stamps rise, unless the date is set back.

    Its owner notes each look for data, with `read` if there was some and with `look` if not.
    For the frames completed by a read it calls `one` or `many`, before it reads again.
    """

    __slots__ = (
        "_asleep_ns",
        "_at_ns",
        "_behind_ns",
        "_count",
        "_date_ns",
        "_drained_ns",
        "_first_ns",
        "_frames",
        "_is_behind",
        "_keeps_all",
        "_last_ns",
        "_looked_ns",
        "_offset",
        "_offset_ns",
        "_prompt_ns",
        "_rhythm",
        "_stamped_ns",
        "_stuck_ns",
        "late",
    )

    def __init__(self, rhythm: Rhythm, *, keeps_all: bool = False) -> None:
        """Start without a frame.

        Args:
            rhythm: Keeps the usual interval.
            keeps_all: Whether to stamp undatable frames too, as well as possible.
        """
        self._rhythm = rhythm
        self._keeps_all = keeps_all
        self._offset = ClockOffset()
        self._offset_ns = _NEVER_NS
        # The last look before the reads that are being stamped; the first and the last of these.
        self._looked_ns = self._first_ns = self._at_ns = 0
        # The date of the last one, and the last one that `more` was told of.
        self._date_ns, self._drained_ns = 0, _NEVER_NS
        # The last stamp, and when it was last asked for with `many`.
        self._last_ns = self._stuck_ns = self._stamped_ns = _NEVER_NS
        # Frames that the rhythm has not been told of, and how many it is told of at once.
        self._frames, self._count = 0, 1
        self._prompt_ns = _PROMPT_NS
        # Whether what was read last was undatable, so that more of it may come; and until when.
        self._is_behind, self._behind_ns = False, 0
        self._asleep_ns = 0
        self.late = 0
        """Number of late frames in the last call of `many`."""

    # What the owner does.

    def begin(self, at_ns: int) -> None:
        """Note that no later data was sent before this moment."""
        self._at_ns = at_ns
        self._is_behind = False
        self._rhythm.pause()
        self._set_pace()

    def look(self, at_ns: int) -> None:
        """Note a look that found no data."""
        self._at_ns = at_ns

    def read(self, date_ns: int, at_ns: int) -> int:
        """Note a read, at that date and that monotonic time; return the latter, for the framer."""
        self._looked_ns = self._at_ns
        self._date_ns = date_ns
        self._at_ns = self._first_ns = at_ns
        return at_ns

    def more(self, date_ns: int, at_ns: int) -> int:
        """Note that the last read goes on: the new data has waited together with the rest."""
        self._date_ns = date_ns
        self._at_ns = self._drained_ns = at_ns
        return at_ns

    def sleep(self, asleep_ns: int) -> None:
        """Note that the machine slept between the last read and the look before."""
        self._looked_ns -= asleep_ns
        self._asleep_ns = asleep_ns

    def shift(self, asleep_ns: int) -> None:
        """Note that the machine slept while there was no data to read."""
        self._offset.shift(asleep_ns)
        self._offset_ns += asleep_ns

    # What it is told.

    @property
    def waited_ns(self) -> int:
        """Time that the last data may have waited: since the previous look."""
        return self._first_ns - self._looked_ns

    @property
    def wants_more(self) -> bool:
        """Whether the wait was so long that more data may be waiting, to be read first.

        For a stream that never pauses, this is true for a moment only. Data that came
        while the reader was busy with it does not count again.
        """
        waited_ns = self._first_ns - self._looked_ns
        if waited_ns <= self._prompt_ns:
            return False
        if self._looked_ns == self._drained_ns and waited_ns <= LATE_NS:
            return False
        return self._at_ns - self._first_ns <= _DRAIN_NS + (waited_ns >> _DRAIN_SHIFT)

    def one(self, begun_ns: int) -> int | None:
        """Return the stamp of the only frame of a read; None if you must call `many`.

        Args:
            begun_ns: The moment of the read in which the frame began.
        """
        at_ns = self._at_ns
        offset_ns = self._date_ns - at_ns
        stamp_ns = offset_ns + begun_ns
        if (
            at_ns - self._looked_ns > self._prompt_ns
            or stamp_ns <= self._last_ns
            or not -SLIGHT_NS < offset_ns - self._offset_ns < SLIGHT_NS
        ):
            return None
        self._last_ns = stamp_ns
        self._frames += 1
        if self._frames >= self._count:
            self._note_rhythm()
        return stamp_ns

    @property
    def may_be_set(self) -> bool:
        """Whether the date of the last read looks as if it had been set."""
        drift_ns = self._date_ns - self._at_ns - self._offset_ns
        return not -SLIGHT_NS < drift_ns < SLIGHT_NS or self._date_ns <= self._last_ns

    def step(self, before_ns: int, date_ns: int, after_ns: int) -> int:
        """Return the step of the date; 0 if there was none. Call it before `many`.

        Args:
            before_ns: The monotonic time before the date was read again.
            date_ns: The date.
            after_ns: The monotonic time after that.
        """
        step_ns = self._offset.step(before_ns, date_ns, after_ns)
        # Frames of one read that are stamped in two parts are no sign of anything.
        is_stuck = self._date_ns <= self._last_ns and self._at_ns > self._stamped_ns
        if step_ns:
            # It may have been set just now.
            self._date_ns = date_ns - (after_ns - self._at_ns)
        elif is_stuck and self._stuck_ns == self._last_ns:
            # A step too small to tell. Stamps stand still for one read, and no longer.
            step_ns = self._date_ns - self._last_ns - 1
        if step_ns:
            self._last_ns = _NEVER_NS
        self._offset_ns = self._offset.offset_ns or 0
        return step_ns

    def many(
        self, begun_ns: Sequence[int], *, is_within: bool = False, wire_ns: int | None = None
    ) -> list[int | None]:
        """Return the stamps of the frames of a read; None for a frame that cannot be dated.

        Args:
            begun_ns: For each frame, the moment of the read in which it began.
            is_within: Whether another frame has begun, behind them.
            wire_ns: Time of a frame on the line, where that is known.
        """
        carried, first_ns, count = 0, self._first_ns, len(begun_ns)
        while carried < count and begun_ns[carried] < first_ns:
            carried += 1
        is_stuck = self._date_ns <= self._last_ns
        stamps = [self._stamp_carried(begun) for begun in begun_ns[:carried]]
        if carried < count:
            here = count - carried
            stamps += self._stamp_begun_here(here, here + is_within, wire_ns)
        self._stuck_ns = self._last_ns if is_stuck else _NEVER_NS
        self._stamped_ns = self._at_ns
        self._asleep_ns = self.late = 0
        if self._is_behind or self._first_ns - self._looked_ns > LATE_NS:
            self.late = self._count_late(stamps)
            self._rhythm.pause()
            self._set_pace()
            return stamps
        # Only now: of these frames nothing is known but what was usual before them.
        self._frames += count
        self._note_rhythm()
        return stamps

    def _count_late(self, stamps: Sequence[int | None]) -> int:
        late_ns = self._date_ns - LATE_NS
        return sum(self._is_behind or stamp is None or stamp < late_ns for stamp in stamps)

    def _note_rhythm(self) -> None:
        self._rhythm.add(self._frames, self._at_ns)
        self._set_pace()

    def _set_pace(self) -> None:
        """Restart counting frames for the rhythm; return the longest prompt wait."""
        usual_ns = self._rhythm.interval_ns
        self._frames, self._count = 0, _FEW if usual_ns else 1
        # What is behind is for `many`.
        prompt_ns = min(max(_PROMPT_NS, usual_ns << _PROMPT_SHIFT), LATE_NS)
        self._prompt_ns = -1 if self._is_behind else prompt_ns

    def _stamp_carried(self, begun_ns: int) -> int | None:
        """Return the stamp of a frame that began in an earlier read."""
        if self._is_behind and begun_ns <= self._behind_ns and not self._keeps_all:
            # It waited together with what was dropped.
            return None
        self._is_behind = False
        known_ns = self._date_ns - (self._at_ns - begun_ns) - self._asleep_ns
        self._last_ns = max(known_ns, self._last_ns + 1)
        return self._last_ns

    def _stamp_begun_here(
        self, count: int, slots: int, wire_ns: int | None
    ) -> Sequence[int | None]:
        """Return the stamps of `count` frames that have begun since the last look.

        There is a slot for each, and one for a frame that has begun behind them.
        """
        usual_ns, waited_ns = self._rhythm.interval_ns, self._at_ns - self._looked_ns
        is_late = self._first_ns - self._looked_ns > LATE_NS
        if is_late or self._is_behind:
            tell = is_undatable if is_late else is_left_over
            self._is_behind = tell(slots, waited_ns, usual_ns)
            if self._is_behind:
                self._behind_ns = self._at_ns
                if not self._keeps_all:
                    return [None] * count
        after_ns = max(self._date_ns - waited_ns, self._last_ns)
        stamps = dates(slots, after_ns, self._date_ns, waited_ns, usual_ns, wire_ns)[:count]
        self._last_ns = stamps[-1]
        return stamps
