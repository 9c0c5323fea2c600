"""Checks that the four calls return in time, whatever the device and the subscriber do."""

from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check

__all__ = ["BoundChecks"]


class BoundChecks(TransportAuthor):
    """Checks of the duration of calls."""

    @check()
    def test_calls_are_bounded_while_the_device_is_silent(self, bench: Bench) -> None:
        """Each call returns in time although the device sends nothing."""
        _, transport, _ = bench.reading()
        transport.stop()
        transport.start(RecordingSubscriber())
        transport.close()

    @check("is_stream")
    def test_calls_are_bounded_within_a_frame(self, bench: Bench) -> None:
        """stop and close return in time although the rest of a frame is missing."""
        peer, transport, _ = bench.reading()
        encoded = peer.encode(self.payload(0))
        half = encoded[: len(encoded) // 2]
        for ending in ("stop", "close"):
            transport.start(RecordingSubscriber())
            before = transport.health.received_bytes
            peer.send_raw(half)
            bench.wait_for_bytes(transport, before + len(half))
            getattr(transport, ending)()

    @check("can_be_absent")
    def test_calls_are_bounded_while_the_device_is_absent(self, bench: Bench) -> None:
        """Each call returns in time although the device is absent."""
        peer = bench.peer()
        made = [bench.transport(peer)]
        if self.capabilities.waits_with:
            made.append(bench.transport(peer, waits=True))
        bench.take_away(peer)
        for transport in made:
            transport.refusal("open")
            transport.refusal("start", RecordingSubscriber())
            transport.stop()
            transport.close()

    @check("can_unplug")
    def test_calls_are_bounded_during_a_reconnect(self, bench: Bench) -> None:
        """Each call returns in time while the transport reconnects."""
        peer, transport, _ = bench.reading()
        peer.unplug()
        bench.wait_for_loss(transport)
        transport.open()
        transport.start(RecordingSubscriber())
        transport.stop()
        transport.refusal("start", RecordingSubscriber())
        transport.close()

    @check()
    def test_calls_are_bounded_while_on_frame_hangs(self, bench: Bench) -> None:
        """stop and close return in time although on_frame does not."""
        peer = bench.peer()
        transport = bench.transport(peer)
        with bench.hanging(peer, transport):
            transport.stop(self.call_limit_s)
            transport.close(self.call_limit_s)

    @check()
    def test_calls_are_bounded_in_a_flood(self, bench: Bench) -> None:
        """stop and close return in time although the device sends as fast as it can."""
        for ending in ("stop", "close"):
            peer, transport, subscriber = bench.reading()
            flood = bench.flood(peer, bench.payloads(100))
            bench.wait_for(subscriber, 100)
            getattr(transport, ending)()
            flood.end()
            transport.close()
