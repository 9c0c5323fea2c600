"""The stamper: the one place that stamps frames, for every transport."""

from collections.abc import Sequence

from rosbase.contracts.transport import Tally, TransportContext
from rosbase.stamps import Timeline

__all__ = ["Stamper"]

_SAY_S = 5.0
_NS_PER_S = 1_000_000_000


class Stamper:
    """Stamps the frames of a transport; counts and logs late frames and steps of the date.

    A transport has one stamper for its life, and calls it on its reader thread. It calls
    `begin` when reading begins, and `look` when there was no data. It calls `read` when there
    was data, and then `one` or `many` for the frames.
    """

    def __init__(self, context: TransportContext, tally: Tally) -> None:
        """Use the clock and the logger of `context`, and count in `tally`."""
        clock = self._clock = context.clock
        self._logger = context.logger
        self._tally = tally
        self._timeline = timeline = Timeline(tally.rhythm, keeps_all=context.frames_are_dated)
        self._asleep_ns = clock.suspended_ns()
        now_ns, monotonic_ns = clock.now_ns, clock.monotonic_ns

        def read() -> int:
            return timeline.read(now_ns(), monotonic_ns())

        self.read = read
        """Note that data has been read; return the moment, for the framer."""
        self.one = timeline.one
        """Return the stamp of the only frame of a read; None if you must call `many`.

        The argument is the value that `read` returned when the frame began.

        The argument is what `read` gave when the frame began.
        """
        timeline.begin(monotonic_ns())

    def begin(self) -> None:
        """Note that reading begins: later data was sent after this moment."""
        self._timeline.shift(self._slept_ns())
        self._timeline.begin(self._clock.monotonic_ns())

    def look(self, until_ns: int) -> None:
        """Note that there was nothing to read.

        A reader that waits for data wakes up for this twice a second. Therefore no data
        has waited for longer, unless the reader stood still.

        Args:
            until_ns: When the wait was to end, on the monotonic clock. A reader that wakes up
                later does not know which data has arrived since.
        """
        self._timeline.look(min(self._clock.monotonic_ns(), until_ns))

    def more(self) -> int:
        """Note that more of the waiting data has been read; return the moment."""
        return self._timeline.more(self._clock.now_ns(), self._clock.monotonic_ns())

    @property
    def wants_more(self) -> bool:
        """Whether the data may have waited, so that the reader should read `more` first."""
        return self._timeline.wants_more

    def many(
        self, begun_ns: Sequence[int], *, is_within: bool = False, wire_ns: int | None = None
    ) -> list[int | None]:
        """Return the stamps of all frames that were completed since `read`.

        None stands for a frame that must not be handed over, because its arrival time is
        unknown.

        Args:
            begun_ns: For each frame, the value that `read` or `more` returned when it began.
            is_within: Whether another frame has begun, behind them.
            wire_ns: How long a frame takes on the line, where that is known.
        """
        timeline, clock = self._timeline, self._clock
        if timeline.may_be_set:
            self._note_step(
                timeline.step(clock.monotonic_ns(), clock.now_ns(), clock.monotonic_ns())
            )
        stamps = timeline.many(begun_ns, is_within=is_within, wire_ns=wire_ns)
        if timeline.late:
            self._note_late(timeline.late, stamps.count(None), timeline.waited_ns)
        return stamps

    def _note_late(self, late: int, dropped: int, waited_ns: int) -> None:
        self._tally.late_frames += late
        if dropped:
            self._tally.frame_errors["late"] = self._tally.frame_errors.get("late", 0) + dropped
        if self._logger.due("late", _SAY_S):
            what = f"{late} frames had waited for over a second"
            if dropped:
                what = (
                    f"{dropped} frames that had waited are dropped, because fewer "
                    "have come than usual, so their arrival times are unknown"
                )
            self._logger.warning(f"nothing was read for {waited_ns / _NS_PER_S:.1f} s: {what}")

    def _note_step(self, step_ns: int) -> None:
        """Count and log a step of the date, except for time in which the machine slept."""
        if not step_ns:
            return
        asleep_ns = self._slept_ns()
        if 2 * asleep_ns > step_ns > 0:
            self._timeline.sleep(asleep_ns)
            return
        self._tally.clock_steps += 1
        way = "forward" if step_ns > 0 else "back"
        if self._logger.due(f"clock set {way}", _SAY_S):
            seconds = abs(step_ns) / _NS_PER_S
            self._logger.warning(f"the clock was set {way} by {seconds:.3f} s; stamps follow it")

    def _slept_ns(self) -> int:
        before_ns, self._asleep_ns = self._asleep_ns, self._clock.suspended_ns()
        return self._asleep_ns - before_ns
