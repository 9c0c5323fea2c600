"""Mutants whose calls go wrong."""

import threading
from itertools import cycle
from queue import SimpleQueue

from rosbase.clock import SystemClock
from rosbase.contracts.transport import OnFrame, TransportState
from rosbase.errors import TransportError
from rosbase.plugins import TransportPlugin
from rosbase.testing import TransportCapabilities
from support.fifo import PARAMETERS, FifoContract, make_transport
from support.mutants.mutant import KeepsSubscriber, Wrapped, mutant, wait_for_release

PAUSE_NS = 1_000_000_000


def take_turns(on_frame: OnFrame) -> OnFrame:
    """Has another thread call it with every other frame."""
    is_others = cycle((False, True))

    def deliver(frame: bytes, stamp_ns: int) -> None:
        if next(is_others):
            thread = threading.Thread(target=on_frame, args=(frame, stamp_ns))
            thread.start()
            thread.join()
        else:
            on_frame(frame, stamp_ns)

    return deliver


@mutant("making-a-transport-touches-nothing", "opened 1 descriptors")
class OpensWhenMade(Wrapped):
    def prepare(self) -> None:
        self.inner.open()


@mutant("making-a-transport-touches-nothing", "started")
class StartsAThreadWhenMade(Wrapped):
    def prepare(self) -> None:
        threading.Thread(target=wait_for_release).start()


@mutant("the-first-parameter-says-which-device", "the first is wait")
class FirstParameterIsAnother(FifoContract):
    def plugin(self) -> TransportPlugin:
        return TransportPlugin("fifo", "lines", make_transport, PARAMETERS[::-1])


@mutant("the-first-parameter-says-which-device", "are no parameters of the plugin")
class PeerNamesStrangeParameters(FifoContract):
    def plugin(self) -> TransportPlugin:
        return TransportPlugin("fifo", "lines", make_transport, PARAMETERS[1:])


class StartsAgain(Wrapped):
    """The second start has another way of handing over begin."""

    on_frame: OnFrame | None = None

    def start(self, on_frame: OnFrame) -> None:
        if self.on_frame is None:
            self.on_frame = on_frame
            self.inner.start(on_frame)
        else:
            self.inner.stop()
            self.inner.start(self.other_way(self.on_frame))

    def other_way(self, on_frame: OnFrame) -> OnFrame:
        raise NotImplementedError


@mutant("each-call-may-be-made-twice", "threads hand over")
class StartsTwoReaders(StartsAgain):
    """Threads that read one device in turn: which of them is first is not left to the system."""

    def other_way(self, on_frame: OnFrame) -> OnFrame:
        return take_turns(on_frame)


@mutant("each-call-may-be-made-twice", "after two starts frames came twice")
class EachStartSubscribes(StartsAgain):
    def other_way(self, on_frame: OnFrame) -> OnFrame:
        def twice(frame: bytes, stamp_ns: int) -> None:
            on_frame(frame, stamp_ns)
            on_frame(frame, stamp_ns)

        return twice


@mutant("each-call-may-be-made-twice", "open() raised")
class OpensOnlyOnce(Wrapped):
    def open(self) -> None:
        if self.inner.is_open:
            raise TransportError("it is open")
        self.inner.open()


@mutant("the-calls-come-in-any-order", "stop() raised RuntimeError")
class StopsOnlyWhatRuns(Wrapped):
    def stop(self) -> None:
        if not self.inner.is_open:
            raise RuntimeError("not started")
        self.inner.stop()


@mutant("start-opens-what-is-not-open", "start() raised")
class StartsOnlyWhatIsOpen(Wrapped):
    def start(self, on_frame: OnFrame) -> None:
        if not self.inner.is_open:
            raise TransportError("it is not open")
        self.inner.start(on_frame)


@mutant("it-starts-again-after-stop-and-after-close", "threads can only be started once")
class StartsOnlyOnce(Wrapped):
    has_started = False

    def start(self, on_frame: OnFrame) -> None:
        if self.has_started:
            raise RuntimeError("threads can only be started once")
        self.has_started = True
        self.inner.start(on_frame)


@mutant("the-calls-come-from-any-thread", "while other threads called")
class IsOfOneThread(Wrapped):
    owner: threading.Thread | None = None

    def open(self) -> None:
        self.check_thread()
        self.inner.open()

    def stop(self) -> None:
        self.check_thread()
        self.inner.stop()

    def check_thread(self) -> None:
        self.owner = self.owner or threading.current_thread()
        if self.owner is not threading.current_thread():
            raise RuntimeError("made on another thread")


@mutant("the-calls-come-from-within-on-frame", "cannot join current thread")
class JoinsItself(Wrapped):
    reader: threading.Thread | None = None

    def start(self, on_frame: OnFrame) -> None:
        def note(frame: bytes, stamp_ns: int) -> None:
            self.reader = threading.current_thread()
            on_frame(frame, stamp_ns)

        self.inner.start(note)

    def stop(self) -> None:
        if self.reader is threading.current_thread():
            raise RuntimeError("cannot join current thread")
        self.inner.stop()


@mutant("the-calls-come-from-within-on-frame", "on_frame was called again although it called stop")
class GoesOnAfterStopFromWithin(Wrapped):
    reader: threading.Thread | None = None

    def start(self, on_frame: OnFrame) -> None:
        def note(frame: bytes, stamp_ns: int) -> None:
            self.reader = threading.current_thread()
            on_frame(frame, stamp_ns)

        if self.reader is not threading.current_thread():
            self.inner.stop()
            self.inner.start(note)

    def stop(self) -> None:
        if self.reader is not threading.current_thread():
            self.inner.stop()


@mutant("calls-are-bounded-while-the-device-is-silent", "stop() has not returned after 0.4 s")
class StopWaitsForData(Wrapped):
    def stop(self) -> None:
        if self.inner.is_open and self.inner.health.frames == 0:
            wait_for_release()
        self.inner.stop()


@mutant("calls-are-bounded-while-the-device-is-absent", "open() has not returned after 0.6 s")
class OpenWaitsForTheDevice(Wrapped):
    def open(self) -> None:
        try:
            self.inner.open()
        except TransportError:
            wait_for_release()


@mutant("calls-are-bounded-during-a-reconnect", "stop() has not returned after 0.4 s")
class StopWaitsForTheDevice(Wrapped):
    def stop(self) -> None:
        if self.inner.health.state is TransportState.RECONNECTING:
            wait_for_release()
        self.inner.stop()


@mutant("calls-are-bounded-while-on-frame-hangs", "stop() has not returned after 0.6 s")
class StopWaitsForOnFrame(Wrapped):
    def prepare(self) -> None:
        self.delivering = threading.Lock()

    def start(self, on_frame: OnFrame) -> None:
        def deliver(frame: bytes, stamp_ns: int) -> None:
            with self.delivering:
                on_frame(frame, stamp_ns)

        self.inner.start(deliver)

    def stop(self) -> None:
        with self.delivering:
            self.inner.stop()


@mutant("calls-are-bounded-in-a-flood", "stop() has not returned after 0.4 s")
class StopWaitsForAPause(Wrapped):
    def stop(self) -> None:
        # As long as the kit allows at least, so that a machine that stalls makes no pause.
        while SystemClock.monotonic_ns() - (self.inner.health.last_data_ns or 0) < PAUSE_NS:
            SystemClock.sleep(0.02)
        self.inner.stop()


@mutant("nothing-is-handed-over-after-the-end", "stop returned while on_frame was running")
@mutant("memory-is-bounded-in-a-flood", "that on_frame did not take")
class HandsOverFromAQueue(Wrapped):
    def prepare(self) -> None:
        self.frames: SimpleQueue[tuple[OnFrame, bytes, int] | None] = SimpleQueue()

    def start(self, on_frame: OnFrame) -> None:
        threading.Thread(target=self.deliver).start()
        self.inner.start(lambda frame, stamp_ns: self.frames.put((on_frame, frame, stamp_ns)))

    def deliver(self) -> None:
        while (item := self.frames.get()) is not None:
            on_frame, frame, stamp_ns = item
            on_frame(frame, stamp_ns)

    def stop(self) -> None:
        self.inner.stop()
        self.frames.put(None)

    def close(self) -> None:
        self.stop()
        self.inner.close()


@mutant("nothing-is-handed-over-after-the-end", "frames came after stop had returned")
class HandsOverWhatIsLeft(KeepsSubscriber):
    """It waits for on_frame, and then hands over the rest of what it has read."""

    def stop(self) -> None:
        self.inner.stop()
        if self.on_frame is not None:
            threading.Timer(0.0, self.on_frame, (b"the rest", 0)).start()


@mutant("every-history-ends-where-the-model-says", "history:  ")
class ForgetsItsSubscriberAfterAnIdleStop(Wrapped):
    """Only a history finds it: stop without a start, and then start."""

    is_spoiled = is_started = False

    def start(self, on_frame: OnFrame) -> None:
        self.inner.start((lambda frame, stamp_ns: None) if self.is_spoiled else on_frame)
        self.is_started = True

    def stop(self) -> None:
        self.is_spoiled = self.inner.is_open and not self.is_started
        self.is_started = False
        self.inner.stop()


@mutant("what-the-peer-can-do-is-declared", "the peer has unplug() and replug(), and")
class DeclaresTooLittle(FifoContract):
    capabilities = TransportCapabilities(is_stream=True)


@mutant("each-call-may-be-made-twice", "the two on_frame got 0 and 20 of 20 frames")
class SecondStartTakesTheNewSubscriber(Wrapped):
    on_frame: OnFrame | None = None

    def start(self, on_frame: OnFrame) -> None:
        self.on_frame = on_frame
        self.inner.start(self.deliver)

    def deliver(self, frame: bytes, stamp_ns: int) -> None:
        if self.on_frame is not None:
            self.on_frame(frame, stamp_ns)


@mutant("calls-are-bounded-within-a-frame", "stop() has not returned after 0.4 s")
class StopWaitsForTheEndOfABegunFrame(Wrapped):
    def stop(self) -> None:
        # Nothing has been handed over of what has arrived.
        if self.inner.is_open and self.inner.health.frames == 0 < self.inner.health.received_bytes:
            wait_for_release()
        self.inner.stop()


@mutant("nothing-is-handed-over-after-the-end", "frames came after stop had returned")
class HandsOverHalfASecondAfterStop(KeepsSubscriber):
    def stop(self) -> None:
        self.inner.stop()
        on_frame, self.on_frame = self.on_frame, None
        if on_frame is not None:
            threading.Timer(0.5, on_frame, (b"the rest", 0)).start()


@mutant("nothing-is-handed-over-after-the-end", "stop returned while on_frame was running")
class SecondStopReturnsAtOnce(Wrapped):
    is_stopping = False

    def stop(self) -> None:
        if self.is_stopping:
            return
        self.is_stopping = True
        try:
            self.inner.stop()
        finally:
            self.is_stopping = False


@mutant("nothing-is-handed-over-after-the-end", "close returned while on_frame was running")
class CloseLeavesItToAStopThatWaits(Wrapped):
    is_stopping = was_left = False

    def stop(self) -> None:
        self.is_stopping = True
        try:
            self.inner.stop()
        finally:
            self.is_stopping = False

    def close(self) -> None:
        # Once, so that whoever tidies up behind the test closes it.
        if self.is_stopping and not self.was_left:
            self.was_left = True
        else:
            self.inner.close()
