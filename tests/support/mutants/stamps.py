"""Mutants that stamp wrongly."""

from itertools import cycle
from typing import Any

from attrs import evolve

from rosbase.clock import SystemClock
from rosbase.contracts.transport import OnFrame, Transport, TransportContext, TransportHealth
from rosbase.logger import RosbaseLogger
from support.fifo import make_transport
from support.mutants.mutant import Wrapped, mutant

SECOND_NS = 1_000_000_000


class Stamped(Wrapped):
    """Stamps frames by a rule of its own."""

    def start(self, on_frame: OnFrame) -> None:
        self.inner.start(lambda frame, stamp_ns: on_frame(frame, self.stamp(stamp_ns)))

    def stamp(self, stamp_ns: int) -> int:
        raise NotImplementedError


@mutant("stamps-lie-between-sending-and-arrival", "after it was handed over")
class StampsLate(Stamped):
    def stamp(self, stamp_ns: int) -> int:
        return stamp_ns + SECOND_NS


@mutant("stamps-lie-between-sending-and-arrival", "before it was sent")
class StampsFromTheStartOfTheMachine(Stamped):
    def stamp(self, stamp_ns: int) -> int:
        return self.context.clock.monotonic_ns()


@mutant("the-stamp-is-that-of-the-first-bytes", "after the first half was read")
class StampsWhenItIsWhole(Stamped):
    def stamp(self, stamp_ns: int) -> int:
        return self.context.clock.now_ns()


@mutant("stamps-strictly-rise", "ms before the last")
class StampsWithJitter(Stamped):
    def prepare(self) -> None:
        self.jitter = cycle((0, -SECOND_NS))

    def stamp(self, stamp_ns: int) -> int:
        return stamp_ns + next(self.jitter)


@mutant("time-is-that-of-the-given-clock", "the stamp is 36")
class StampsWithAnotherClock(Stamped):
    def stamp(self, stamp_ns: int) -> int:
        return SystemClock.now_ns()


@mutant("time-is-that-of-the-given-clock", "last_data_ns is not the clock's")
class DatesDataWithAnotherClock(Wrapped):
    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, last_data_ns=SystemClock.monotonic_ns())


@mutant("stamps-lie-between-sending-and-arrival", "none was stamped sooner than 0.0")
class StampsAfterItsWork(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        def work(frame: bytes, stamp_ns: int) -> None:
            SystemClock.sleep(0.03)
            on_frame(frame, self.context.clock.now_ns())

        self.inner.start(work)


@mutant("stamps-strictly-rise", "two frames had the same stamp")
class HasOneStampForARead(Stamped):
    def stamp(self, stamp_ns: int) -> int:
        return stamp_ns // SECOND_NS * SECOND_NS


@mutant("frames-read-together-are-spread", "were stamped")
class StampsAllThatIsReadAsNow(Stamped):
    last_ns = 0

    def stamp(self, stamp_ns: int) -> int:
        self.last_ns = max(self.last_ns + 1, self.context.clock.now_ns())
        return self.last_ns


@mutant("frames-read-together-are-spread", "after it was read")
class SpreadsIntoTheFuture(Stamped):
    last_ns = 0

    def stamp(self, stamp_ns: int) -> int:
        self.last_ns = max(stamp_ns, self.last_ns + SECOND_NS)
        return self.last_ns


@mutant("a-pause-before-a-burst-says-nothing-of-it", "before it was sent")
class SpreadsOverThePause(Stamped):
    last_ns = 0

    def stamp(self, stamp_ns: int) -> int:
        # As if four more came with it.
        self.last_ns += (stamp_ns - self.last_ns) // 5 if self.last_ns else stamp_ns
        return self.last_ns


@mutant("what-has-waited-is-not-stamped-as-new", "was stamped 1.")
class StampsWhatIsOldAsNew(Wrapped):
    def make(self) -> Transport:
        # As if the frames carried dates, and these stamps did not count.
        return make_transport(self.values, evolve(self.context, frames_are_dated=True))


@mutant("what-has-waited-is-not-stamped-as-new", "health.late_frames was 0")
class CountsNothingAsLate(Wrapped):
    dropped = 0

    @property
    def health(self) -> TransportHealth:
        health = self.inner.health
        return evolve(health, frames=health.frames + health.late_frames, late_frames=0)


class Silent(RosbaseLogger):
    """Says nothing of its own accord."""

    def warning(self, message: object, *values: object, **options: Any) -> None:
        """Nothing."""


class SaysNothing(Wrapped):
    def make(self) -> Transport:
        context: TransportContext = evolve(self.context, logger=Silent("silent"))
        return make_transport(self.values, context)


@mutant("what-has-waited-is-not-stamped-as-new", "nothing was logged")
class SaysNothingOfWhatIsLate(SaysNothing):
    pass


@mutant("a-clock-that-is-set-is-one-break", "the log had 0 lines")
class SaysNothingOfAStep(SaysNothing):
    pass


@mutant("a-clock-that-is-set-is-one-break", "the date was set by -7200 s")
class NeverGoesBack(Stamped):
    last_ns = 0

    def stamp(self, stamp_ns: int) -> int:
        self.last_ns = max(self.last_ns + 1, stamp_ns)
        return self.last_ns


@mutant("a-clock-that-is-set-is-one-break", "health.clock_steps was 0")
class CountsNoSteps(Wrapped):
    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, clock_steps=0)
