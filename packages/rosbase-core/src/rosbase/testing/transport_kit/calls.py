"""Checks of open, start, stop and close: repeated, in any order, from any thread."""

import random
import threading
from collections.abc import Callable

import pytest

from rosbase.contracts.transport import Transport, TransportState
from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.resources import descriptors, threads
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.capabilities import ABILITIES
from rosbase.testing.transport_kit.check import check

__all__ = ["CallChecks"]

_CALLERS = 4
_CALLS = 25
# Time to wait for an event that must not happen.
_AGAIN_S = 0.1
_LATE_S = 0.6


class CallChecks(TransportAuthor):
    """Checks of the four calls."""

    @check()
    def test_making_a_transport_touches_nothing(self, bench: Bench) -> None:
        """The constructor opens no device and starts no thread. The transport is closed."""
        peer = bench.peer()
        bench.transport(peer)
        before, open_before = threads(), descriptors()
        transport = bench.transport(peer)
        started = threads() - before
        bench.require(not started, f"started {', '.join(t.name for t in started)}")
        opened = descriptors() - open_before
        bench.require(opened <= 0, f"opened {opened} descriptors")
        bench.require(not transport.is_open, "is_open was true")
        state = transport.state
        bench.require(state is TransportState.CLOSED, f"health.state was {state.name}")

    @check()
    def test_the_first_parameter_says_which_device(self, bench: Bench) -> None:
        """The first parameter of the plugin names the device; peers give it a value."""
        if not self.transport:
            pytest.skip(f"{type(self).__name__}.transport names no installed transport")
        specs = self.plugin().parameters
        bench.require(specs, "the TransportPlugin has no parameters")
        names = [spec.name for spec in specs]
        first, second = dict(bench.peer().parameters), dict(bench.peer().parameters)
        strange = set(first) - set(names)
        bench.require(
            not strange, f"the peer's {', '.join(strange)} are no parameters of the plugin"
        )
        bench.require(names[0] in first, f"the first is {names[0]}, which a peer does not give")
        bench.require(
            first[names[0]] != second[names[0]],
            f"two devices have the same {names[0]}: {first[names[0]]!r}",
        )

    @check()
    def test_what_the_peer_can_do_is_declared(self, bench: Bench) -> None:
        """If a peer can send raw bytes or be unplugged, the test declares it."""
        peer = bench.peer()
        # If nothing is implemented yet, the failure must say so.
        bench.transport(peer).open()
        for capability in ("is_stream", "can_unplug"):
            abilities = ABILITIES[capability]
            can = all(callable(getattr(peer.made, name, None)) for name in abilities)
            bench.require(
                getattr(self.capabilities, capability) or not can,
                f"the peer has {'() and '.join(abilities)}(), "
                f"and TransportCapabilities({capability}=True) is not declared",
            )

    @check()
    def test_each_call_may_be_made_twice(self, bench: Bench) -> None:
        """Each of the four calls may be made twice; the second call does nothing."""
        peer = bench.peer()
        transport, subscriber = bench.transport(peer), RecordingSubscriber()
        other = RecordingSubscriber()
        transport.open()
        transport.open()
        transport.start(subscriber)
        transport.start(other)
        sent = bench.payloads(40)
        peer.send(*sent[:20])
        if not bench.arrives(subscriber, 20):
            counts = f"{len(subscriber.frames)} and {len(other.frames)} of 20 frames"
            raise bench.promise.broken(f"after two starts the two on_frame got {counts}")
        for count, payload in enumerate(sent[20:], start=21):
            # One by one, because either of two waiting threads may wake first.
            peer.send(payload)
            bench.wait_for(subscriber, count)
        more = len(other.frames)
        bench.require(not more, f"after two starts the second on_frame got {more} frames")
        bench.require(subscriber.frames == sent, "after two starts frames came twice or disordered")
        readers = {received.thread for received in subscriber.received}
        bench.require(len(readers) == 1, f"after two starts {len(readers)} threads hand over")
        transport.stop()
        transport.stop()
        transport.close()
        transport.close()

    @check()
    def test_the_calls_come_in_any_order(self, bench: Bench) -> None:
        """The four calls may come in any order; stopping what is not running does nothing."""
        peer = bench.peer()
        transport = bench.transport(peer)
        transport.stop()
        transport.close()
        transport.stop()
        transport.open()
        transport.close()
        transport.open()
        transport.stop()
        bench.prove(peer, transport)
        transport.close()
        transport.stop()
        bench.require(not transport.is_open, "is_open was true after close and stop")

    @check()
    def test_start_opens_what_is_not_open(self, bench: Bench) -> None:
        """start opens a transport that is not open."""
        peer = bench.peer()
        transport = bench.transport(peer)
        bench.prove(peer, transport)
        bench.require(transport.is_open, "is_open was false after start")

    @check()
    def test_it_starts_again_after_stop_and_after_close(self, bench: Bench) -> None:
        """After stop, and after close, start reads again."""
        peer = bench.peer()
        transport = bench.transport(peer)
        for ending in (transport.stop, transport.close, transport.stop):
            bench.prove(peer, transport)
            ending()
        bench.prove(peer, transport)

    @check()
    def test_the_calls_come_from_any_thread(self, bench: Bench) -> None:
        """Several threads may make the four calls at once."""
        peer = bench.peer()
        transport = bench.transport(peer)
        callers = [_RandomCaller(transport.made, seed) for seed in range(_CALLERS)]
        for caller in callers:
            caller.thread.start()
        for caller in callers:
            caller.thread.join(self.call_limit_s * _CALLERS)
        for caller in callers:
            bench.require(not caller.failure, caller.failure)
            bench.require(not caller.thread.is_alive(), "the calls of four threads do not end")
        transport.close()
        state = transport.state
        bench.require(state is TransportState.CLOSED, f"health.state was {state.name} after close")
        bench.prove(peer, transport)

    @check()
    def test_the_calls_come_from_within_on_frame(self, bench: Bench) -> None:
        """on_frame may make the four calls; after stop or close it is not called again."""
        for ending in ("stop", "close"):
            peer = bench.peer()
            transport = bench.transport(peer)
            visitor = _Visitor(transport.made, ending)
            transport.start(visitor)
            peer.send(*bench.payloads(3))
            in_time = visitor.has_left.wait(self.call_limit_s)
            bench.require(in_time, f"the calls from within on_frame took {self.call_limit_s:g} s")
            bench.require(not visitor.failure, visitor.failure)
            visitor.is_back.wait(_AGAIN_S)
            seen = f"on_frame was called again although it called {ending}"
            bench.require(visitor.calls == 1, seen)
            if ending == "close":
                bench.wait_until(
                    # mypy does not infer what a default of a lambda is.
                    lambda made=transport: made.state is TransportState.CLOSED,  # type: ignore[misc]  # mypy infers no default of a lambda
                    "health.state to be CLOSED after a close from within on_frame",
                )
            bench.prove(peer, transport)
            bench.require(visitor.calls == 1, seen)

    @check()
    def test_nothing_is_handed_over_after_the_end(self, bench: Bench) -> None:
        """stop and close wait for on_frame to return; after them it is not called again."""
        for ending in ("stop", "close"):
            peer = bench.peer()
            transport = bench.transport(peer)
            with bench.hanging(peer, transport) as hung:
                # A call that arrives while another one waits must wait too.
                names = (ending, "stop", "close")
                calls = [bench.in_background(getattr(transport.made, name)) for name in names]
                calls[0].join(_AGAIN_S)
                for name, call in zip(names, calls, strict=True):
                    bench.require(call.is_alive(), f"{name} returned while on_frame was running")
            for name, call in zip(names, calls, strict=True):
                call.join(self.call_limit_s)
                bench.require(not call.is_alive(), f"{name} did not return after on_frame had")
            peer.send(*bench.payloads(5))
            bench.prove(peer, transport)
            transport.stop()
            bench.clock.sleep(_LATE_S)
            more = len(hung.frames) - 1
            bench.require(not more, f"{more} frames came after {ending} had returned")


class _RandomCaller:
    """Thread that makes random calls, and records the first that raises."""

    def __init__(self, transport: Transport, seed: int) -> None:
        self.failure = ""
        self._transport = transport
        self._choose = random.Random(seed)
        self.thread = threading.Thread(target=self._run, name="rosbase-kit-random", daemon=True)

    def _run(self) -> None:
        transport = self._transport
        subscriber = RecordingSubscriber()
        calls: dict[str, Callable[[], object]] = {
            "open": transport.open,
            "start": lambda: transport.start(subscriber),
            "stop": transport.stop,
            "close": transport.close,
            "health": lambda: transport.health,
        }
        for _ in range(_CALLS):
            name = self._choose.choice(sorted(calls))
            try:
                calls[name]()
            except BaseException as error:
                self.failure = f"{name} raised {error!r} while other threads called"
                return


class _Visitor:
    """`on_frame` that makes the calls."""

    def __init__(self, transport: Transport, ending: str) -> None:
        self.calls = 0
        self.failure = ""
        self.has_left, self.is_back = threading.Event(), threading.Event()
        self._transport = transport
        self._ending = ending

    def __call__(self, frame: bytes, stamp_ns: int) -> None:
        self.calls += 1
        if self.calls > 1:
            self.is_back.set()
        transport = self._transport
        try:
            transport.open()
            getattr(transport, self._ending)()
            transport.start(self)
        except BaseException as error:
            self.failure = f"from within on_frame a call raised {error!r}"
        self.has_left.set()
