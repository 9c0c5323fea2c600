"""Checks that all sent frames are delivered unaltered, once, and nothing else."""

from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check

__all__ = ["FrameChecks"]

_BATCH = 20
_BATCHES = 10
_MANY = 200
_STARTS = 10
_TIMES = 3


class FrameChecks(TransportAuthor):
    """Checks of frames."""

    @check()
    def test_frames_arrive_unaltered(self, bench: Bench) -> None:
        """A payload arrives as one frame, byte for byte: as bytes, with a stamp that is an int."""
        peer, _, subscriber = bench.reading()
        for payload in self.payloads:
            subscriber.clear()
            peer.send(payload)
            bench.wait_for(subscriber, 1)
            bench.require_frames(subscriber, [payload])
            ((frame, stamp_ns, *_),) = subscriber.received
            kinds = (type(frame), type(stamp_ns))
            seen = f"on_frame was given {kinds[0].__name__} and {kinds[1].__name__}"
            bench.require(kinds == (bytes, int), f"{seen}, not bytes and int")

    @check()
    def test_frames_arrive_in_order(self, bench: Bench) -> None:
        """Frames arrive in the order in which they were sent, each once."""
        peer, _, subscriber = bench.reading()
        sent: list[bytes] = []
        for _ in range(_BATCHES):
            batch = bench.payloads(_BATCH, first=len(sent))
            peer.send(*batch)
            sent += batch
            bench.wait_for(subscriber, len(sent))
        bench.require_frames(subscriber, sent)

    @check("is_stream")
    def test_frames_in_one_piece_are_kept_apart(self, bench: Bench) -> None:
        """Frames that arrive in one chunk are delivered one by one."""
        peer, _, subscriber = bench.reading()
        sent = bench.payloads(_MANY)
        peer.send_raw(b"".join(peer.encode(payload) for payload in sent))
        bench.wait_for(subscriber, len(sent))
        bench.require_frames(subscriber, sent)

    @check("is_stream")
    def test_a_frame_in_pieces_is_put_together(self, bench: Bench) -> None:
        """A frame that arrives in pieces is delivered when it is complete."""
        peer, transport, subscriber = bench.reading()
        (payload,) = bench.payloads(1)
        encoded = peer.encode(payload)
        for start in range(0, len(encoded), 7):
            before = transport.health.received_bytes
            peer.send_raw(encoded[start : start + 7])
            bench.wait_for_bytes(transport, before + 1)
        bench.wait_for(subscriber, 1)
        bench.require_frames(subscriber, [payload])

    @check("is_stream")
    def test_frames_after_junk_are_whole(self, bench: Bench) -> None:
        """After junk, few frames are lost or damaged; later frames are complete, none merged."""
        peer, _, subscriber = bench.reading()
        begun = peer.encode(self.payload(9_000))
        for junk in (*self.junk, begun[: len(begun) // 2]):
            subscriber.clear()
            spoiled = bench.payloads(self.capabilities.frames_lost_after_junk)
            whole = bench.payloads(5, first=len(spoiled))
            peer.send_raw(junk)
            peer.send(*spoiled, *whole)
            arrived = bench.frame_arrives(subscriber, whole[-1])
            bench.require(arrived, f"the frame {_shown(whole[-1])} after junk never came")
            last = subscriber.frames[-len(whole) :]
            seen = f"after {_shown(junk)} came {', '.join(map(_shown, last))}"
            bench.require(last == whole, seen)

    @check("bad_frames")
    def test_a_bad_frame_does_not_end_the_stream(self, bench: Bench) -> None:
        """An invalid frame is not delivered and does not end the stream."""
        peer, _, subscriber = bench.reading()
        for bad in self.capabilities.bad_frames:
            subscriber.clear()
            first, second = bench.payloads(2)
            peer.send(first)
            bench.wait_for(subscriber, 1)
            peer.send_raw(bad)
            peer.send(second)
            bench.wait_for(subscriber, 2)
            bench.require_frames(subscriber, [first, second])

    @check("is_stream")
    def test_a_frame_begun_before_a_stop_is_not_continued(self, bench: Bench) -> None:
        """A frame begun before stop is neither delivered nor continued after the next start."""
        peer, transport, subscriber = bench.reading()
        begun, whole = bench.payloads(2)
        half = peer.encode(begun)[: len(peer.encode(begun)) // 2]
        peer.send_raw(half)
        bench.wait_for_bytes(transport, len(half))
        transport.stop()
        after = RecordingSubscriber()
        transport.start(after)
        peer.send(whole)
        bench.wait_for(after, 1)
        bench.require_frames(after, [whole])
        came = subscriber.frames
        bench.require(not came, f"half a frame was handed over: {', '.join(map(_shown, came))}")

    @check("bad_frames")
    def test_bad_frames_are_counted(self, bench: Bench) -> None:
        """health.frame_errors counts invalid frames, under a few reasons of one word."""
        peer, transport, subscriber = bench.reading()
        kinds = self.capabilities.bad_frames
        for count, bad in enumerate(kinds * _TIMES, start=1):
            peer.send_raw(bad)
            peer.send(*bench.payloads(1))
            bench.arrives(subscriber, count)
            health = transport.health
            errors = dict(health.frame_errors)
            seen = f"after {count} bad frames, health.frame_errors was {errors}"
            bench.require(sum(errors.values()) == count, seen)
            bench.require(all(len(reason.split()) == 1 for reason in errors), seen)
            bench.require(len(errors) <= len(kinds), f"{seen}: a reason for each")
            bench.require(health.frames == count, f"health.frames was {health.frames}, not {count}")

    @check()
    def test_what_came_before_start_is_discarded(self, bench: Bench) -> None:
        """Data from before start is not delivered: its arrival time is unknown."""
        peer = bench.peer()
        transport = bench.transport(peer)
        transport.open()
        stale, fresh = bench.payloads(5, first=100), bench.payloads(2)
        for _ in range(3):
            peer.send(*stale)
            subscriber = RecordingSubscriber()
            transport.start(subscriber)
            peer.send(*fresh)
            arrived = bench.frame_arrives(subscriber, fresh[-1])
            bench.require(arrived, "what was sent after start did not arrive")
            old = [frame for frame in subscriber.frames if frame in stale]
            bench.require(not old, f"{len(old)} frames arrived that were sent before start")
            transport.stop()

    @check()
    def test_what_comes_after_start_is_handed_over(self, bench: Bench) -> None:
        """Data that the device sends after start has returned is delivered."""
        peer = bench.peer()
        transport = bench.transport(peer)
        for _ in range(_STARTS):
            subscriber = RecordingSubscriber()
            transport.start(subscriber)
            sent = bench.payloads(2)
            peer.send(*sent)
            bench.wait_for(subscriber, 2)
            bench.require_frames(subscriber, sent)
            transport.stop()

    @check()
    def test_two_transports_do_not_disturb_each_other(self, bench: Bench) -> None:
        """Two transports deliver their own data, and one goes on when the other ends."""
        one_peer, one, one_subscriber = bench.reading()
        other_peer, other, other_subscriber = bench.reading()
        ones, others = bench.payloads(_BATCH), bench.payloads(_BATCH, first=_BATCH)
        for pair in zip(ones, others, strict=True):
            one_peer.send(pair[0])
            other_peer.send(pair[1])
        bench.wait_for(one_subscriber, _BATCH)
        bench.wait_for(other_subscriber, _BATCH)
        bench.require_frames(one_subscriber, ones)
        bench.require_frames(other_subscriber, others)
        counted = one.health.frames
        bench.require(counted == _BATCH, f"one of them counted {counted} frames, not {_BATCH}")
        one.close()
        bench.require(other.is_open, "closing one of them closed the other")
        other_peer.send(*ones)
        bench.wait_for(other_subscriber, 2 * _BATCH)


def _shown(data: bytes) -> str:
    return repr(data) if len(data) <= 80 else f"{data[:40]!r}... ({len(data)} bytes)"
