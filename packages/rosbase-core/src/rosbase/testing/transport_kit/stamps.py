"""Checks of the stamps of frames."""

import threading
from itertools import pairwise

from rosbase.testing.recording import Received, RecordingSubscriber
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check
from rosbase.testing.transport_kit.clocks import ShiftedClock, SteppingClock
from rosbase.testing.transport_kit.guarded_peer import GuardedPeer

__all__ = ["StampChecks"]

_NS_PER_S = 1_000_000_000
_NS_PER_MS = 1_000_000
_MANY = 100
# Enough for a transport to learn the usual interval.
_LEARNED, _INTERVAL_S = 20, 0.02
# Number of frames that wait while nobody reads. A busy machine may make them uneven once,
# but not each time.
_WAITING, _TRIES = 5, 5
_PAUSE_S = 0.6
# The promise is about data that waits for more than a second.
_STALL_S, _NEW_S = 1.6, 0.8
_STEPS_S = (3_600, -7_200)


class Stall:
    """`on_frame` that blocks the reader, from the next frame until `end`."""

    def __init__(self, bench: Bench) -> None:
        self.subscriber = RecordingSubscriber(then=self._hold)
        self._patience_s = bench.author.patience_s
        self._is_wanted = False
        self._over = threading.Event()

    def begin(self) -> None:
        """Hold the reader at the next frame."""
        self._over.clear()
        self._is_wanted = True

    def end(self) -> None:
        """Let the reader go on."""
        self._is_wanted = False
        self._over.set()

    def _hold(self, frame: bytes, stamp_ns: int) -> None:
        if self._is_wanted:
            self._is_wanted = False
            self._over.wait(self._patience_s)


class StampChecks(TransportAuthor):
    """Checks of stamps."""

    @check()
    def test_stamps_lie_between_sending_and_arrival(self, bench: Bench) -> None:
        """A lone frame is stamped with the time when its first bytes were read."""
        peer, _, subscriber = bench.reading()
        delays_ns = []
        for payload in bench.payloads(20):
            subscriber.clear()
            sent_ns = bench.clock.now_ns()
            peer.send(payload)
            bench.wait_for(subscriber, 1)
            (received,) = subscriber.received
            early_ns = sent_ns - received.stamp_ns
            bench.require(early_ns <= 0, f"stamped {early_ns / 1e6:.3f} ms before it was sent")
            late_ns = received.stamp_ns - received.arrived_ns
            bench.require(late_ns <= 0, f"stamped {late_ns / 1e6:.3f} ms after it was handed over")
            delays_ns.append(-early_ns)
        # On a busy machine, one frame may be late, but not all of them.
        shortest_s = min(delays_ns) / 1e9
        seen = f"of 20 frames none was stamped sooner than {shortest_s:.4f} s after it was sent"
        bench.require(shortest_s < self.stamp_limit_s, seen)

    @check("is_stream")
    def test_the_stamp_is_that_of_the_first_bytes(self, bench: Bench) -> None:
        """A frame that arrives in two halves has the stamp of the first."""
        peer, transport, subscriber = bench.reading()
        (payload,) = bench.payloads(1)
        encoded = peer.encode(payload)
        half = len(encoded) // 2
        peer.send_raw(encoded[:half])
        bench.wait_for_bytes(transport, half)
        between_ns = bench.clock.now_ns()
        peer.send_raw(encoded[half:])
        bench.wait_for(subscriber, 1)
        late_ns = subscriber.received[0].stamp_ns - between_ns
        bench.require(late_ns <= 0, f"stamped {late_ns / 1e6:.3f} ms after the first half was read")

    @check()
    def test_stamps_strictly_rise(self, bench: Bench) -> None:
        """Each stamp is later than the one before, unless the date was set back."""
        peer, _, subscriber = bench.reading()
        for first in range(0, _MANY, 10):
            if self.capabilities.is_stream:
                peer.send_raw(b"".join(map(peer.encode, bench.payloads(10, first))))
            else:
                peer.send(*bench.payloads(10, first))
            bench.wait_for(subscriber, first + 10)
        stamps = [received.stamp_ns for received in subscriber.received]
        least_ns = min(after - before for before, after in pairwise(stamps))
        seen = f"a stamp was {-least_ns / 1e6:.3f} ms before the last"
        bench.require(least_ns > 0, seen if least_ns else "two frames had the same stamp")

    @check()
    def test_frames_read_together_are_spread(self, bench: Bench) -> None:
        """Stamps of frames read together are spread evenly over the time since the last read."""
        peer, stall = bench.peer(), Stall(bench)
        bench.transport(peer).start(stall.subscriber)
        _learn(bench, peer, stall.subscriber)
        for attempt in range(_TRIES):
            stall.subscriber.clear()
            stall.begin()
            payloads = bench.payloads(1 + _WAITING, first=100 + 10 * attempt)
            peer.send(payloads[0])
            bench.wait_for(stall.subscriber, 1)
            for payload in payloads[1:]:
                bench.clock.sleep(_INTERVAL_S)
                peer.send(payload)
            bench.clock.sleep(_INTERVAL_S / 2)
            stall.end()
            bench.wait_for(stall.subscriber, 1 + _WAITING)
            received = stall.subscriber.received
            gaps_ms = _gaps_ms(received)
            early_ns = max(each.stamp_ns - each.arrived_ns for each in received)
            bench.require(early_ns <= 0, f"stamped {early_ns / 1e6:.3f} ms after it was read")
            if min(gaps_ms) > _INTERVAL_S * 1e3 / 4:
                return
        shown = ", ".join(f"{gap:.3f}" for gap in gaps_ms)
        raise bench.promise.broken(
            f"{_WAITING} frames that came {_INTERVAL_S * 1e3:g} ms apart while on_frame ran "
            f"were stamped {shown} ms apart"
        )

    @check()
    def test_a_pause_before_a_burst_says_nothing_of_it(self, bench: Bench) -> None:
        """Frames that are read together after a pause are no farther apart than usual."""
        peer, _, subscriber = bench.reading()
        _learn(bench, peer, subscriber)
        for attempt in range(_TRIES):
            subscriber.clear()
            bench.clock.sleep(_PAUSE_S)
            sent_ns = bench.clock.now_ns()
            payloads = bench.payloads(_WAITING, first=100 + 10 * attempt)
            if self.capabilities.is_stream:
                peer.send_raw(b"".join(map(peer.encode, payloads)))
            else:
                peer.send(*payloads)
            bench.wait_for(subscriber, _WAITING)
            early_s = (sent_ns - subscriber.received[0].stamp_ns) / 1e9
            if early_s <= 2 * _WAITING * _INTERVAL_S:
                return
        raise bench.promise.broken(
            f"after a pause of {_PAUSE_S:g} s, the first of {_WAITING} frames was stamped "
            f"{early_s:.3f} s before it was sent; usually they came {_INTERVAL_S:g} s apart"
        )

    @check()
    def test_what_has_waited_is_not_stamped_as_new(self, bench: Bench) -> None:
        """Frames that waited unread for over a second are counted and not stamped as new."""
        peer, stall = bench.peer(), Stall(bench)
        transport = bench.transport(peer)
        transport.start(stall.subscriber)
        _learn(bench, peer, stall.subscriber)
        stall.subscriber.clear()
        stall.begin()
        first, *waiting, new = bench.payloads(2 + _WAITING, first=100)
        peer.send(first)
        bench.wait_for(stall.subscriber, 1)
        sent_ns = bench.clock.now_ns()
        peer.send(*waiting)
        bench.clock.sleep(_STALL_S)
        lines = len(bench.log.lines)
        stall.end()
        bench.wait_until(
            lambda: transport.health.frames + transport.health.late_frames >= _LEARNED + 6,
            f"{_WAITING} frames that had waited to be handed over, or counted in late_frames",
        )
        peer.send(new)
        arrived = bench.frame_arrives(stall.subscriber, new)
        bench.require(arrived, "a frame that came after the others was not handed over")
        for received in stall.subscriber.received[1:]:
            new_s = (received.stamp_ns - sent_ns) / 1e9
            is_old = received.frame == new or new_s < _NEW_S
            bench.require(is_old, f"what waited for {_STALL_S:g} s was stamped {new_s:.3f} s late")
        late = transport.health.late_frames
        seen = f"health.late_frames was {late} after {_WAITING} frames that waited {_STALL_S:g} s"
        bench.require(late >= _WAITING, seen)
        bench.require(len(bench.log.lines) > lines, f"nothing was logged of {late} late frames")

    @check()
    def test_a_clock_that_is_set_is_one_break(self, bench: Bench) -> None:
        """When the date is set, stamps follow at once, and one step is counted and logged."""
        clock = SteppingClock()
        peer, transport, subscriber = bench.reading(clock)
        peer.send(*bench.payloads(3))
        bench.wait_for(subscriber, 3)
        for number, step_s in enumerate(_STEPS_S, start=1):
            subscriber.clear()
            lines = len(bench.log.lines)
            clock.ahead_ns += step_s * _NS_PER_S
            sent_ns = clock.now_ns()
            for payload in bench.payloads(3, first=10 * number):
                peer.send(payload)
            bench.wait_for(subscriber, 3)
            off_s = [(each.stamp_ns - sent_ns) / 1e9 for each in subscriber.received]
            now_s = (clock.now_ns() - sent_ns) / 1e9
            is_now = all(-_INTERVAL_S * 3 <= off <= now_s for off in off_s)
            shown = ", ".join(f"{off:.3f}" for off in off_s)
            bench.require(is_now, f"the date was set by {step_s} s; the stamps were {shown} s off")
            steps = transport.health.clock_steps
            bench.require(steps == number, f"health.clock_steps was {steps} after step {number}")
            said = len(bench.log.lines) - lines
            bench.require(said == 1, f"the log had {said} lines of a date that was set once")

    @check()
    def test_time_is_that_of_the_given_clock(self, bench: Bench) -> None:
        """Stamps and health.last_data_ns use the clock of the context."""
        clock = ShiftedClock()
        peer, transport, subscriber = bench.reading(clock)
        sent_ns, sent_at_ns = clock.now_ns(), clock.monotonic_ns()
        peer.send(*bench.payloads(1))
        bench.wait_for(subscriber, 1)
        stamp_ns, last_ns = subscriber.received[0].stamp_ns, transport.health.last_data_ns
        off_s = (stamp_ns - sent_ns) / 1e9
        is_now = sent_ns <= stamp_ns <= clock.now_ns()
        bench.require(is_now, f"on a clock of the kit's, the stamp is {off_s:.3f} s off")
        is_now = last_ns is not None and sent_at_ns <= last_ns <= clock.monotonic_ns()
        bench.require(is_now, "health.last_data_ns is not the clock's monotonic_ns")


def _learn(bench: Bench, peer: GuardedPeer, subscriber: RecordingSubscriber) -> None:
    """Send frames at one interval, so that the transport learns the usual one."""
    for number, payload in enumerate(bench.payloads(_LEARNED), start=1):
        peer.send(payload)
        bench.wait_for(subscriber, number)
        bench.clock.sleep(_INTERVAL_S)


def _gaps_ms(received: list[Received]) -> list[float]:
    stamps = [each.stamp_ns for each in received]
    return [(after - before) / _NS_PER_MS for before, after in pairwise(stamps)]
