"""Checks that a transport releases its resources and that they do not grow."""

from collections.abc import Callable

from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.resources import cpu_s, descriptors, memory_growth, threads, wanted_cpu_s
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check
from rosbase.testing.transport_kit.flood import Flood

__all__ = ["ResourceChecks"]

_TIMES_THE_LIMIT = 4
_IDLE_S = 0.4
_AGAIN_S = 0.3


class ResourceChecks(TransportAuthor):
    """Checks of threads, descriptors, the device and memory."""

    @check()
    def test_close_ends_its_threads(self, bench: Bench) -> None:
        """After close, the transport's threads have ended, whatever happened before."""
        for name, live in self._lives(bench).items():
            live()
            # Counted, because a peer that comes back may have threads of its own.
            before = len(threads())
            for _ in range(self._times):
                live()
            bench.wait_until(
                # mypy does not infer what a default of a lambda is.
                lambda before=before: len(threads()) <= before,  # type: ignore[misc]  # mypy infers no default of a lambda
                f"the end of threads after close; it was {name}",
                self.end_limit_s,
            )

    @check()
    def test_close_gives_descriptors_back(self, bench: Bench) -> None:
        """After close, the transport has no open descriptor, whatever happened before."""
        for name, live in self._lives(bench).items():
            live()
            before = descriptors()
            for _ in range(self._times):
                live()
            bench.wait_until(
                lambda before=before: descriptors() <= before,  # type: ignore[misc]  # mypy infers no default of a lambda  # as above
                f"descriptors after {self._times} times to be {before}, as after one; "
                f"it was {name}",
                self.end_limit_s,
            )

    @check()
    def test_close_gives_the_device_back(self, bench: Bench) -> None:
        """After close, another transport can open the device."""
        peer = bench.peer()
        for _ in range(3):
            transport = bench.transport(peer)
            bench.prove(peer, transport)
            transport.close()

    @check()
    def test_an_on_frame_that_hung_leaves_nothing_behind(self, bench: Bench) -> None:
        """When an on_frame that hung returns, its thread ends and the device is released."""
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
        """A device that was lost and came back leaves no extra thread and no extra descriptor."""
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
        """Data that arrives faster than on_frame takes it does not pile up in the transport."""
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

    @check()
    def test_memory_is_bounded_while_it_reads(self, bench: Bench) -> None:
        """The transport keeps no frame after it was delivered or counted as an error."""
        peer = bench.peer()
        transport = bench.transport(peer)
        transport.start(lambda frame, stamp_ns: None)
        longest = max((*self.payloads, self.payload(0)), key=len)
        floods: list[tuple[Callable[[bytes], object], list[bytes]]] = [(peer.made.send, [longest])]
        if self.capabilities.bad_frames:
            floods.append((peer.made.send_raw, list(self.capabilities.bad_frames)))
        for send, payloads in floods:
            with memory_growth() as growth:
                flood = Flood(send, payloads)
                flood.wait_for(self.memory_limit_bytes * _TIMES_THE_LIMIT, self.patience_s)
                flood.end()
                bench.wait_for_silence(transport)
                grown = growth()
            seen = f"{grown} bytes more after {flood.sent_bytes} bytes that were read"
            bench.require(grown < self.memory_limit_bytes, seen)

    @check()
    def test_waiting_costs_no_processor(self, bench: Bench) -> None:
        """While nothing arrives, or the device is away, it waits without using the processor."""
        peer, transport, _ = bench.reading()
        self._require_idle(bench, "nothing arrived")
        if self.capabilities.can_unplug:
            peer.unplug()
            bench.wait_for_loss(transport)
            self._require_idle(bench, "the device was away")

    @property
    def _times(self) -> int:
        """Return the number of repetitions of each life; some take a while."""
        return max(2, self.cycles // 3)

    def _require_idle(self, bench: Bench, while_what: str) -> None:
        before_s, wanted_before_s = cpu_s(), wanted_cpu_s()
        bench.clock.sleep(_IDLE_S)
        used_s, wanted_s = cpu_s() - before_s, wanted_cpu_s() - wanted_before_s
        seen = f"{used_s:.2f} s of the processor in {_IDLE_S:g} s while {while_what}"
        bench.require(used_s < _IDLE_S / 5, seen)
        # On a busy machine, a busy loop gets only a share of a processor, but waits for the rest.
        seen = f"{wanted_s:.2f} s of the processor were wanted in {_IDLE_S:g} s while {while_what}"
        bench.require(wanted_s < _IDLE_S / 2, seen)

    def _lives(self, bench: Bench) -> dict[str, Callable[[], None]]:
        """Return complete lives of a transport, from the first call to close, by name."""
        peer = bench.peer()
        transport = bench.transport(peer)

        def read(*endings: Callable[[], None]) -> Callable[[], None]:
            def live() -> None:
                for end in endings:
                    bench.prove(peer, transport)
                    end()

            return live

        def only_open() -> None:
            transport.open()
            transport.close()

        def close_from_within() -> None:
            subscriber = RecordingSubscriber(then=lambda *_: transport.made.close())
            transport.start(subscriber)
            peer.send(*bench.payloads(2))
            bench.wait_for(subscriber, 1)
            transport.close()

        def close_without_device() -> None:
            bench.prove(peer, transport)
            peer.unplug()
            bench.wait_for_loss(transport)
            transport.close()
            peer.replug()
            # A thread that still waits for it takes it now.
            bench.clock.sleep(_AGAIN_S)

        lives = {
            "reading": read(transport.close),
            "stopped": read(transport.stop, transport.stop, transport.close),
            "open, and not started": only_open,
            "closed from within on_frame": close_from_within,
        }
        if self.capabilities.can_unplug:
            lives["without its device"] = close_without_device
        return lives
