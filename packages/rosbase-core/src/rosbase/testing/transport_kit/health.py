"""Checks that health and is_open are correct, and return at once."""

from rosbase.contracts.transport import TransportState
from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check

__all__ = ["HealthChecks"]

# Maximum number of bytes of a frame in addition to its payload.
_MOST_AROUND = 1_000


class HealthChecks(TransportAuthor):
    """Checks of health and is_open."""

    @check()
    def test_is_open_is_true_as_long_as_the_device_is_held(self, bench: Bench) -> None:
        """is_open is True from open to close, also after stop."""
        peer = bench.peer()
        transport = bench.transport(peer)
        bench.require(not transport.is_open, "is_open was true before open")
        transport.open()
        bench.require(transport.is_open, "is_open was false after open")
        bench.prove(peer, transport)
        bench.require(transport.is_open, "is_open was false while it reads")
        transport.stop()
        bench.require(transport.is_open, "is_open was false after stop, which keeps the device")
        transport.close()
        bench.require(not transport.is_open, "is_open was true after close")

    @check()
    def test_the_state_says_what_it_is_doing(self, bench: Bench) -> None:
        """health.state is CLOSED before open and after close, and CONNECTED in between."""
        peer = bench.peer()
        transport = bench.transport(peer)
        _require_state(bench, transport.state, TransportState.CLOSED, "before open")
        transport.open()
        _require_state(bench, transport.state, TransportState.CONNECTED, "after open")
        bench.prove(peer, transport)
        _require_state(bench, transport.state, TransportState.CONNECTED, "while it reads")
        transport.close()
        _require_state(bench, transport.state, TransportState.CLOSED, "after close")

    @check()
    def test_health_counts_what_arrives(self, bench: Bench) -> None:
        """health counts frames and bytes; valid frames cause no errors."""
        peer, transport, subscriber = bench.reading()
        sent = bench.payloads(20)
        peer.send(*sent)
        bench.wait_for(subscriber, len(sent))
        health = transport.health
        bench.require(health.frames == len(sent), f"frames was {health.frames}, not {len(sent)}")
        least, most = sum(map(len, sent)), sum(len(payload) + _MOST_AROUND for payload in sent)
        seen = f"received_bytes was {health.received_bytes} after {least} bytes of payload"
        bench.require(least <= health.received_bytes <= most, seen)
        bench.require(not health.frame_errors, f"frame_errors was {dict(health.frame_errors)}")
        bench.require(not health.last_error, f"last_error was {health.last_error!r}")

    @check()
    def test_counts_go_on_over_stop_and_close(self, bench: Bench) -> None:
        """The counts in health start when the transport is made and are never reset."""
        peer = bench.peer()
        transport = bench.transport(peer)
        sent = bench.payloads(15)
        for count, ending in ((5, transport.stop), (10, transport.close), (15, transport.stop)):
            subscriber = RecordingSubscriber()
            transport.start(subscriber)
            peer.send(*sent[count - 5 : count])
            bench.wait_for(subscriber, 5)
            ending()
            health = transport.health
            least = sum(map(len, sent[:count]))
            is_so = health.frames == count and health.received_bytes >= least
            seen = f"frames was {health.frames}, received_bytes {health.received_bytes}"
            bench.require(
                is_so, f"{seen}, after {count} frames and {least} bytes of payload in all"
            )

    @check()
    def test_only_data_proves_that_a_device_is_alive(self, bench: Bench) -> None:
        """health.last_data_ns is when bytes last arrived; without bytes it does not change."""
        peer, transport, subscriber = bench.reading()
        never = transport.health.last_data_ns
        bench.require(never is None, f"it was {never} before anything arrived")
        before_ns = bench.clock.monotonic_ns()
        peer.send(*bench.payloads(1))
        bench.wait_for(subscriber, 1)
        last_ns = transport.health.last_data_ns
        is_so = last_ns is not None and before_ns <= last_ns <= bench.clock.monotonic_ns()
        bench.require(is_so, f"it was {last_ns} after data that arrived after {before_ns}")
        transport.stop()
        transport.start(RecordingSubscriber())
        again_ns = transport.health.last_data_ns
        bench.require(again_ns == last_ns, "it changed although nothing arrived")

    @check()
    def test_health_never_waits(self, bench: Bench) -> None:
        """health and is_open return at once, also while stop waits for an on_frame that hangs."""
        peer = bench.peer()
        transport = bench.transport(peer)
        with bench.hanging(peer, transport):
            _ = (transport.health, transport.is_open)
            ending = bench.in_background(transport.made.stop)
            deadline_ns = bench.clock.monotonic_ns() + int(self.call_limit_s * 1e9)
            # Another check tests that stop returns.
            while ending.is_alive() and bench.clock.monotonic_ns() < deadline_ns:
                _ = (transport.health, transport.is_open)
                ending.join(0.05)


def _require_state(bench: Bench, state: TransportState, wanted: TransportState, when: str) -> None:
    bench.require(state is wanted, f"health.state was {state.name} {when}, not {wanted.name}")
