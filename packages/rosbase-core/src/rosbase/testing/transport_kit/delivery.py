"""Checks of the thread that delivers frames."""

from collections.abc import Iterable
from itertools import cycle
from typing import Any

from rosbase.contracts.transport import TransportState
from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check
from rosbase.testing.transport_kit.clocks import FailingClock
from rosbase.testing.transport_kit.guarded_peer import GuardedPeer
from rosbase.testing.transport_kit.guarded_transport import GuardedTransport

__all__ = ["DeliveryChecks"]

_SOME = 40
# Behaviour of on_frame, frame by frame: answer True or False, give no answer, or raise.
_ANSWERS: dict[str, tuple[object, ...]] = {
    "True": (True,),
    "False": (False,),
    "None": (None,),
    "one thing after another": (True, False, None, ValueError("no good"), 0, "no", False, False),
}


class DeliveryChecks(TransportAuthor):
    """Checks of the delivery of frames."""

    @check()
    def test_on_frame_is_called_on_one_thread_of_its_own(self, bench: Bench) -> None:
        """From start to stop, on_frame is called on one thread, which is no caller's thread."""
        peer = bench.peer()
        transport = bench.transport(peer)
        subscriber = RecordingSubscriber()
        transport.start(subscriber)
        peer.send(*bench.payloads(20))
        bench.wait_for(subscriber, 20)
        handing_over = {received.thread for received in subscriber.received}
        bench.require(len(handing_over) == 1, f"{len(handing_over)} threads called on_frame")
        names = ", ".join(thread.name for thread in handing_over)
        strange = handing_over & (transport.threads | peer.threads)
        bench.require(not strange, f"on_frame was called on the thread of a caller, {names}")

    @check()
    def test_what_on_frame_raises_does_not_end_the_stream(self, bench: Bench) -> None:
        """If on_frame raises, even SystemExit, the next frames are delivered."""
        for error in (ValueError("no good"), SystemExit(3)):
            peer, _, subscriber = _raising(bench, error)
            sent = bench.payloads(20)
            peer.send(*sent)
            if not bench.arrives(subscriber, len(sent)):
                came = len(subscriber.frames)
                raise bench.promise.broken(f"{came} of {len(sent)} frames came after {error!r}")

    @check()
    def test_what_on_frame_raises_is_logged(self, bench: Bench) -> None:
        """Exceptions from on_frame are logged as errors, at a limited rate."""
        for error in (ValueError("no good"), SystemExit(3)):
            peer, transport, subscriber = _raising(bench, error)
            peer.send(*bench.payloads(_SOME))
            bench.wait_for(subscriber, _SOME)
            # When the thread has ended, all delivered frames have been logged.
            transport.stop()
            bench.require(bench.log.tells_of(error), f"{error!r} was not logged as an error")
            lines = sum(repr(error) in line for line in bench.log.lines)
            seen = f"{error!r} was logged {lines} times for {_SOME} frames"
            bench.require(lines <= _SOME // 4, seen)

    @check()
    def test_what_on_frame_answers_changes_nothing_in_delivery(self, bench: Bench) -> None:
        """The return value of on_frame does not change delivery: each next frame arrives once."""
        for name, answers in _ANSWERS.items():
            peer, transport, subscriber = _answering(bench, answers)
            sent = bench.payloads(_SOME)
            peer.send(*sent)
            if not bench.arrives(subscriber, len(sent)):
                came = len(subscriber.frames)
                raise bench.promise.broken(f"{came} of {_SOME} frames came when it answered {name}")
            # By then, a frame delivered twice has arrived twice.
            transport.stop()
            bench.require_frames(subscriber, sent)
            counted = transport.health.frames
            seen = f"health.frames was {counted} when it answered {name}, not {_SOME}"
            bench.require(counted == _SOME, seen)

    @check()
    def test_a_reader_that_dies_is_noticed(self, bench: Bench) -> None:
        """If the reader thread fails, health reports it, and start reads again."""
        clock = FailingClock()
        peer, transport, subscriber = bench.reading(clock)
        peer.send(*bench.payloads(1))
        bench.wait_for(subscriber, 1)
        clock.failure = MemoryError("the clock fails, as the kit has it do")
        peer.send(*bench.payloads(1, first=1))
        bench.wait_until(
            lambda: len(subscriber.frames) > 1 or transport.state is TransportState.CLOSED,
            "health.state to be CLOSED after the thread has failed",
        )
        if len(subscriber.frames) == 1:
            bench.wait_until(lambda: not transport.is_open, "the device to be given back")
            bench.require(transport.health.last_error, "health.last_error was empty")
            bench.require(bench.log.tells_of(clock.failure), "the failure was not logged")
        clock.failure = None
        bench.prove(peer, transport)


def _raising(
    bench: Bench, error: BaseException
) -> tuple[GuardedPeer, GuardedTransport, RecordingSubscriber]:
    """Make a transport whose subscriber raises that at every frame."""
    return _answering(bench, (error,))


def _answering(
    bench: Bench, answers: Iterable[object]
) -> tuple[GuardedPeer, GuardedTransport, RecordingSubscriber]:
    """Make a transport whose subscriber returns these in turn, and raises exceptions."""
    turns = cycle(answers)

    def answer(frame: bytes, stamp_ns: int) -> Any:
        given = next(turns)
        if isinstance(given, BaseException):
            raise given
        return given

    peer = bench.peer()
    transport = bench.transport(peer)
    subscriber = RecordingSubscriber(then=answer)
    transport.start(subscriber)
    return peer, transport, subscriber
