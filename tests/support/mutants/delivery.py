"""Mutants that hand over wrongly."""

import sys
import threading

from attrs import evolve

from rosbase.contracts.transport import OnFrame, TransportHealth, TransportState
from support.mutants.mutant import Wrapped, mutant


@mutant("on-frame-is-called-on-one-thread-of-its-own", "20 threads called on_frame")
class HasAThreadForEachFrame(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            thread = threading.Thread(target=on_frame, args=(frame, stamp_ns))
            thread.start()
            thread.join()

        self.inner.start(deliver)


@mutant("what-on-frame-raises-does-not-end-the-stream", "1 of 20 frames came after ValueError")
class EndsOfAnException(Wrapped):
    is_dead = False

    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            if not self.is_dead:
                self.is_dead = True
                on_frame(frame, stamp_ns)
                self.is_dead = False

        self.inner.start(deliver)


@mutant("what-on-frame-raises-does-not-end-the-stream", "1 of 20 frames came after SystemExit")
class EndsOfSystemExit(Wrapped):
    has_exited = False

    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            try:
                if not self.has_exited:
                    on_frame(frame, stamp_ns)
            except SystemExit:
                self.has_exited = True
                raise

        self.inner.start(deliver)


@mutant("what-on-frame-raises-is-logged", "was not logged as an error")
class SaysNothingOfAnException(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            try:
                on_frame(frame, stamp_ns)
            except BaseException:
                self.error = sys.exc_info()[1]

        self.inner.start(deliver)


class HeedsAnswers(Wrapped):
    """Does something about what `on_frame` answers."""

    def start(self, on_frame: OnFrame) -> None:
        self.inner.start(lambda frame, stamp_ns: self.heed(on_frame, frame, stamp_ns))

    def heed(self, on_frame: OnFrame, frame: bytes, stamp_ns: int) -> bool | None:
        raise NotImplementedError


@mutant("what-on-frame-answers-changes-nothing-in-delivery", "1 of 40 frames came when it answered")
class EndsWithTheFirstRefusal(HeedsAnswers):
    was_refused = False

    def heed(self, on_frame: OnFrame, frame: bytes, stamp_ns: int) -> bool | None:
        if self.was_refused:
            return None
        self.was_refused = (answer := on_frame(frame, stamp_ns)) is False
        return answer


@mutant("what-on-frame-answers-changes-nothing-in-delivery", "frame 1 of 40 was")
class TriesAgainWhatWasRefused(HeedsAnswers):
    def heed(self, on_frame: OnFrame, frame: bytes, stamp_ns: int) -> bool | None:
        return on_frame(frame, stamp_ns) is not False or on_frame(frame, stamp_ns)


@mutant("what-on-frame-answers-changes-nothing-in-delivery", "20 of 40 frames came when")
class SkipsAFrameAfterNoAnswer(HeedsAnswers):
    skips = False

    def heed(self, on_frame: OnFrame, frame: bytes, stamp_ns: int) -> bool | None:
        answer = None if self.skips else on_frame(frame, stamp_ns)
        self.skips = answer is None and not self.skips
        return answer


@mutant("what-on-frame-answers-changes-nothing-in-delivery", "one thing after another")
class GivesUpOnWhatIsNoAnswer(HeedsAnswers):
    is_dead = False

    def heed(self, on_frame: OnFrame, frame: bytes, stamp_ns: int) -> bool | None:
        answer = None if self.is_dead else on_frame(frame, stamp_ns)
        self.is_dead = self.is_dead or answer not in (True, False, None)
        return answer


@mutant("what-on-frame-answers-changes-nothing-in-delivery", "health.frames was 0 when")
class CountsSamplesOnly(Wrapped):
    """Counts a frame when a sample came of it."""

    samples = 0

    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> bool | None:
            answer = on_frame(frame, stamp_ns)
            self.samples += answer is True
            return answer

        self.inner.start(deliver)

    @property
    def health(self) -> TransportHealth:
        return evolve(self.inner.health, frames=self.samples)


@mutant("a-reader-that-dies-is-noticed", "health.state to be CLOSED")
class DoesNotNoticeADeadReader(Wrapped):
    is_wanted = False

    def open(self) -> None:
        self.is_wanted = True
        self.inner.open()

    def close(self) -> None:
        self.is_wanted = False
        self.inner.close()

    @property
    def health(self) -> TransportHealth:
        health = self.inner.health
        return evolve(health, state=TransportState.CONNECTED) if self.is_wanted else health


@mutant("what-on-frame-raises-is-logged", "was logged 40 times for 40 frames")
class LogsEachException(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            try:
                on_frame(frame, stamp_ns)
            except BaseException as error:
                self.context.logger.error(repr(error))

        self.inner.start(deliver)
