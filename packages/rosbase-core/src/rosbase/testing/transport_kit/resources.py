"""What a transport takes, it gives back, and it never takes more and more."""

from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.resources import descriptors, memory_growth, threads
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check
from rosbase.testing.transport_kit.flood import Flood

__all__ = ["ResourceChecks"]

_TIMES_THE_LIMIT = 4


class ResourceChecks(TransportAuthor):
    """What is promised about threads, descriptors, the device and memory."""

    @check()
    def test_close_ends_its_threads(self, bench: Bench) -> None:
        """Once close has returned, the transport's threads have ended, also after many cycles."""
        peer = bench.peer()
        transport = bench.transport(peer)
        self._cycle(bench)
        before = threads()
        for _ in range(self.cycles):
            bench.prove(peer, transport)
            transport.close()
        bench.wait_until(lambda: not threads() - before, "the end of threads after close")

    @check()
    def test_close_gives_descriptors_back(self, bench: Bench) -> None:
        """Once close has returned, no descriptor of the transport's is open."""
        peer = bench.peer()
        transport = bench.transport(peer)
        bench.prove(peer, transport)
        transport.close()
        before = descriptors()
        for _ in range(self.cycles):
            bench.prove(peer, transport)
            transport.close()
        bench.wait_until(
            lambda: descriptors() <= before,
            f"descriptors after {self.cycles} times open and close to be {before}, as after one",
        )

    @check()
    def test_close_gives_the_device_back(self, bench: Bench) -> None:
        """Once close has returned, another transport can have the device."""
        peer = bench.peer()
        for _ in range(3):
            transport = bench.transport(peer)
            bench.prove(peer, transport)
            transport.close()

    @check()
    def test_an_on_frame_that_hung_leaves_nothing_behind(self, bench: Bench) -> None:
        """When an on_frame that hung returns at last, its thread ends and the device is free."""
        peer = bench.peer()
        before = threads()
        transport = bench.transport(peer)
        with bench.hanging(peer, transport):
            transport.close(self.call_limit_s)
        bench.wait_until(lambda: not threads() - before, "the end of the thread that was left")
        bench.prove(peer, bench.transport(peer))

    @check("can_be_absent")
    def test_a_failed_open_leaks_nothing(self, bench: Bench) -> None:
        """An open that fails leaves no thread and no descriptor."""
        peer = bench.peer()
        transport = bench.transport(peer)
        bench.take_away(peer)
        transport.refusal("open")
        before, open_before = threads(), descriptors()
        for _ in range(self.cycles):
            transport.refusal("open")
        bench.wait_until(lambda: not threads() - before, "the end of threads after a failed open")
        bench.wait_until(
            lambda: descriptors() <= open_before, "no more descriptors after failed opens"
        )

    @check("can_unplug")
    def test_a_reconnect_leaks_nothing(self, bench: Bench) -> None:
        """A device that was lost and came back costs no thread and no descriptor."""
        peer, transport, subscriber = bench.reading()
        counts = []
        for _ in range(3):
            peer.unplug()
            bench.wait_for_loss(transport)
            peer.replug()
            bench.wait_for_return(peer, subscriber)
            counts.append((len(threads()), descriptors()))
        bench.require(
            counts[-1][0] <= counts[0][0] and counts[-1][1] <= counts[0][1],
            f"threads and descriptors after one, two and three losses: {counts}",
        )

    @check("is_stream")
    def test_memory_is_bounded_without_an_end_of_frame(self, bench: Bench) -> None:
        """Bytes that never end a frame do not pile up."""
        peer, transport, _ = bench.reading()
        peer.send_raw(self.endless)
        bench.wait_for_bytes(transport, len(self.endless))
        wanted = self.memory_limit_bytes * _TIMES_THE_LIMIT
        with memory_growth() as growth:
            sent = 0
            while sent < wanted:
                peer.send_raw(self.endless)
                sent += len(self.endless)
            bench.wait_for_bytes(transport, len(self.endless) + sent)
            grown = growth()
        bench.require(
            grown < self.memory_limit_bytes, f"{grown} bytes more after {sent} bytes without an end"
        )

    @check()
    def test_memory_is_bounded_in_a_flood(self, bench: Bench) -> None:
        """What arrives faster than on_frame takes it does not pile up in the transport."""
        peer = bench.peer()
        transport = bench.transport(peer)
        wanted = self.memory_limit_bytes * _TIMES_THE_LIMIT
        payload = max((*self.payloads, self.payload(0)), key=len)
        with bench.hanging(peer, transport):
            with memory_growth() as growth:
                flood = Flood(peer.made.send, [payload])
                flood.wait_for(wanted, self.patience_s)
                grown = growth()
            flood.end()
        seen = f"{grown} bytes more after {flood.sent_bytes} bytes that on_frame did not take"
        bench.require(grown < self.memory_limit_bytes, seen)

    def _cycle(self, bench: Bench) -> None:
        """One of whatever is made once and kept, such as a thread of a library's."""
        peer = bench.peer()
        transport = bench.transport(peer)
        transport.start(RecordingSubscriber())
        transport.close()
