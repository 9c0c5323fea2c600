"""Mutants that do not hand over what was sent."""

from pathlib import Path
from typing import Any

from attrs import evolve

from rosbase.contracts.transport import (
    OnFrame,
    SimulatedDevice,
    Transport,
    TransportContext,
    TransportHealth,
)
from rosbase.framing import Frame, FrameEvent, LineFramer
from rosbase.testing import TransportCapabilities
from support.fifo import FifoContract, FifoDevice, FifoPeer, make_transport
from support.mutants.framers import TrustingLengths
from support.mutants.mutant import KeepsSubscriber, Wrapped, mutant


class Framed(Wrapped):
    """Has a framer of its own."""

    framer: type[LineFramer] = LineFramer

    def make(self) -> Transport:
        return make_transport(self.values, self.context, framer=self.framer())


@mutant("frames-arrive-unaltered", "frame 0 of 1 was b'xxxx")
class Truncates(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        self.inner.start(lambda frame, stamp_ns: on_frame(frame[:1_024], stamp_ns))


@mutant("frames-arrive-unaltered", "instead of")
class TakesEverythingForText(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        self.inner.start(
            lambda frame, stamp_ns: on_frame(frame.decode("ascii", "ignore").encode(), stamp_ns)
        )


@mutant("frames-arrive-in-order", "instead of")
class SwapsPairs(Wrapped):
    waiting: bytes | None = None

    def start(self, on_frame: OnFrame) -> None:
        def swap(frame: bytes, stamp_ns: int) -> None:
            first, self.waiting = self.waiting, None if self.waiting else frame
            if first is not None:
                on_frame(frame, stamp_ns)
                on_frame(first, stamp_ns)

        self.inner.start(swap)


@mutant("frames-arrive-in-order", "instead of")
class HandsOverTwice(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        def twice(frame: bytes, stamp_ns: int) -> None:
            on_frame(frame, stamp_ns)
            on_frame(frame, stamp_ns)

        self.inner.start(twice)


class EachReadIsAFrame(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [Frame(data.rstrip(b"\n"), stamp_ns)]


@mutant("frames-in-one-piece-are-kept-apart", "of 200 frames")
@mutant("a-frame-in-pieces-is-put-together", "instead of")
class HasNoFramer(Framed):
    framer = EachReadIsAFrame


class MergesAfterJunk(LineFramer):
    """As one that loses its place: the second frame after junk swallows the third."""

    lost_place = False
    held: Frame | None = None

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events: list[FrameEvent] = []
        for event in super().feed(data, stamp_ns):
            if not isinstance(event, Frame):
                self.lost_place = True
            elif self.lost_place and self.held is None:
                self.held = event
                continue
            elif self.held is not None:
                events.append(Frame(self.held.data + event.data, stamp_ns))
                self.lost_place, self.held = False, None
                continue
            events.append(event)
        return events


@mutant("frames-after-junk-are-whole", "after b'xxxx")
class MergesFramesAfterJunk(Framed):
    framer = MergesAfterJunk


class DiesOfABadFrame(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = super().feed(data, stamp_ns)
        if not all(isinstance(event, Frame) for event in events):
            raise ValueError("a bad frame")
        return events


@mutant("a-bad-frame-does-not-end-the-stream", "1 of 2 frames")
class ReaderDiesOfABadFrame(Framed):
    framer = DiesOfABadFrame


class HandsOverBadFrames(LineFramer):
    def __init__(self) -> None:
        super().__init__(1_000_000)


@mutant("a-bad-frame-does-not-end-the-stream", "instead of")
class HandsOverWhatIsBad(Framed):
    framer = HandsOverBadFrames


class CountsNothing(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [event for event in super().feed(data, stamp_ns) if isinstance(event, Frame)]


@mutant("bad-frames-are-counted", "health.frame_errors was {}")
class CountsNoBadFrames(Framed):
    framer = CountsNothing


class KeepsInput(FifoDevice):
    def discard_input(self) -> None:
        pass


@mutant("what-came-before-start-is-discarded", "5 frames arrived that were sent before start")
class HandsOverOldFrames(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, self.context, device=KeepsInput)


class DiscardsLate(FifoDevice):
    has_discarded = False

    def discard_input(self) -> None:
        self.has_discarded = False

    def read(self) -> bytes:
        if not self.has_discarded:
            self.has_discarded = True
            super().discard_input()
        return super().read()


@mutant("what-comes-after-start-is-handed-over", "of 2 frames had arrived")
class DiscardsAfterStart(Wrapped):
    def make(self) -> Transport:
        return make_transport(self.values, self.context, device=DiscardsLate)


@mutant("two-transports-do-not-disturb-each-other", "0 of 20 frames")
class SharesItsSubscriber(Wrapped):
    shared: list[OnFrame] = []  # noqa: RUF012 - shared, which is what is wrong

    def start(self, on_frame: OnFrame) -> None:
        self.shared.append(on_frame)
        self.inner.start(self.deliver)

    def deliver(self, frame: bytes, stamp_ns: int) -> None:
        self.shared[-1](frame, stamp_ns)


class Given(Wrapped):
    """Gives on_frame something else than bytes and int."""

    def start(self, on_frame: OnFrame) -> None:
        self.inner.start(lambda frame, stamp_ns: self.give(on_frame, frame, stamp_ns))

    def give(self, on_frame: Any, frame: bytes, stamp_ns: int) -> None:
        raise NotImplementedError


@mutant("frames-arrive-unaltered", "on_frame was given bytearray and int")
class GivesByteArrays(Given):
    def give(self, on_frame: Any, frame: bytes, stamp_ns: int) -> None:
        on_frame(bytearray(frame), stamp_ns)


@mutant("frames-arrive-unaltered", "on_frame was given bytes and float")
class GivesSeconds(Given):
    def give(self, on_frame: Any, frame: bytes, stamp_ns: int) -> None:
        on_frame(frame, float(stamp_ns))


class DropsABurst(LineFramer):
    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return super().feed(data, stamp_ns)[:20]


@mutant("frames-in-one-piece-are-kept-apart", "of 200 frames")
class DropsWhatIsTooMuchForOneRead(Framed):
    framer = DropsABurst


class CountsEachBadFrameByItself(LineFramer):
    count = 0

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return [self.named(event) for event in super().feed(data, stamp_ns)]

    def named(self, event: FrameEvent) -> FrameEvent:
        if isinstance(event, Frame):
            return event
        self.count += 1
        return event._replace(reason=f"{event.reason}-{self.count}")


@mutant("bad-frames-are-counted", "a reason for each")
class HasAReasonForEachBadFrame(Framed):
    framer = CountsEachBadFrameByItself


@mutant("bad-frames-are-counted", "health.frames was")
class CountsBadFramesAsFrames(Wrapped):
    @property
    def health(self) -> TransportHealth:
        health = self.inner.health
        return evolve(health, frames=health.frames + sum(health.frame_errors.values()))


class LengthPeer(FifoPeer):
    def encode(self, payload: bytes) -> bytes:
        return TrustingLengths.MARKS + len(payload).to_bytes(2, "big") + payload


@mutant("frames-after-junk-are-whole", "came")
class MergesAfterAFrameThatIsCutShort(FifoContract):
    capabilities = TransportCapabilities(is_stream=True, can_unplug=True)
    call_limit_s = end_limit_s = patience_s = 0.6
    junk = ()

    def payload(self, number: int) -> bytes:
        # The one that is cut short is longer than those that come after it.
        return b"%d" % number * (200 if number == 9_000 else 1)

    def make_peer(self) -> SimulatedDevice:
        return LengthPeer(Path(self._folder.name))

    def make_transport(self, peer: Any, context: TransportContext) -> Transport:
        return make_transport({"wait": False, **peer.parameters}, context, framer=TrustingLengths())


class KeepsWhatWasBegun(LineFramer):
    def reset(self) -> None:
        """Keeps it, as for the rest that is to come."""


@mutant("a-frame-begun-before-a-stop-is-not-continued", "instead of")
class ContinuesAfterAStop(Framed):
    framer = KeepsWhatWasBegun


@mutant("a-frame-begun-before-a-stop-is-not-continued", "half a frame was handed over")
class HandsOverHalfAFrame(KeepsSubscriber):
    def stop(self) -> None:
        self.inner.stop()
        if self.on_frame is not None and self.inner.health.frames == 0:
            self.on_frame(b"half", self.context.clock.now_ns())
