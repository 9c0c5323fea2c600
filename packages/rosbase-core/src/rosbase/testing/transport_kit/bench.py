"""Test bench of a check: peers, transports, and a timeout for every call."""

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import cast

from attrs import frozen

from rosbase.clock import Clock, SystemClock
from rosbase.contracts.transport import SimulatedDevice, Transport, TransportContext, TransportState
from rosbase.logger import RosbaseLogger
from rosbase.parameters import ParameterValue
from rosbase.testing.promise import BrokenPromiseError, Promise
from rosbase.testing.recorded_log import RecordedLog
from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.seen import not_written, raised
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.capabilities import ABILITIES, FullPeer
from rosbase.testing.transport_kit.flood import Flood
from rosbase.testing.transport_kit.guarded_peer import GuardedPeer
from rosbase.testing.transport_kit.guarded_transport import GuardedTransport, Limits
from rosbase.testing.transport_kit.promises import CALLS, FACTORY, PEER, PEER_ABILITIES

__all__ = ["Bench"]

_LOG = "transport_contract"
_LOOK_S = 0.002
_PROBE_S = 0.05
_SILENCE_S = 0.2


@frozen
class _Parameters:
    """The part of a peer that a factory uses."""

    parameters: Mapping[str, ParameterValue]
    peer: SimulatedDevice

    def __getattr__(self, name: str) -> object:
        return getattr(self.peer, name)


class Bench:
    """Bench of one check: makes peers and transports, waits, and cleans up at the end."""

    def __init__(self, author: TransportAuthor, promise: Promise) -> None:
        """Start without peers and transports."""
        self.author = author
        self.promise = promise
        self.probes = self.payloads(2, first=9_998)
        """Payloads sent to see whether data flows."""
        self.log = RecordedLog(_LOG)
        self.clock = SystemClock()
        self._peers: list[GuardedPeer] = []
        self._transports: list[GuardedTransport] = []

    def require(self, holds: object, seen: str) -> None:
        """Fail with the promise of the check unless it holds."""
        self.promise.require(holds, seen)

    def peer(self) -> GuardedPeer:
        """Make a peer with the declared abilities."""
        peer = _made(self.author.make_peer, PEER, "make_peer")
        missing = [name for name in ("parameters", "send", "close") if name not in dir(peer)]
        PEER.require(not missing, f"{type(peer).__name__} has no {' and no '.join(missing)}")
        guarded = GuardedPeer(cast(FullPeer, peer), self.promise, self.author.patience_s)
        self._peers.append(guarded)
        self._check_abilities(guarded)
        return guarded

    def transport(
        self,
        peer: GuardedPeer,
        clock: Clock | None = None,
        *,
        waits: bool = False,
        reopens: bool = False,
    ) -> GuardedTransport:
        """Make a transport for the peer; if told to, one that waits for it or reopens it."""
        can = self.author.capabilities
        more = {**(can.waits_with if waits else {}), **(can.reopens_with if reopens else {})}
        view = _Parameters({**peer.parameters, **more}, peer.made)
        context = TransportContext(clock or self.clock, RosbaseLogger(_LOG))
        made = _made(
            lambda: self.author.make_transport(cast(SimulatedDevice, view), context),
            FACTORY,
            "make_transport",
        )
        if not isinstance(made, Transport):
            raise FACTORY.broken(f"make_transport gave {made!r}, which is no Transport")
        limits = Limits(self.author.call_limit_s, self.author.end_limit_s)
        self._transports.append(GuardedTransport(made, self.promise, limits))
        return self._transports[-1]

    def reading(
        self, clock: Clock | None = None
    ) -> tuple[GuardedPeer, GuardedTransport, RecordingSubscriber]:
        """Return a peer, a started transport, and the subscriber."""
        peer = self.peer()
        transport = self.transport(peer, clock)
        subscriber = RecordingSubscriber(clock)
        transport.open()
        transport.start(subscriber)
        return peer, transport, subscriber

    def prove(self, peer: GuardedPeer, transport: GuardedTransport) -> None:
        """Start the transport, and check that frames arrive."""
        subscriber = RecordingSubscriber()
        transport.start(subscriber)
        peer.send(*self.payloads(2))
        self.wait_for(subscriber, 2)

    def take_away(self, peer: GuardedPeer) -> None:
        """Leave the transport without a device."""
        if self.author.capabilities.can_unplug:
            peer.unplug()
        else:
            peer.made.close()

    @contextmanager
    def hanging(
        self, peer: GuardedPeer, transport: GuardedTransport
    ) -> Iterator[RecordingSubscriber]:
        """Yield while an `on_frame` of the transport does not return."""
        leave, left = threading.Event(), threading.Event()

        def hang(frame: bytes, stamp_ns: int) -> None:
            leave.wait()
            left.set()

        hung = RecordingSubscriber(then=hang)
        transport.start(hung)
        peer.send(*self.payloads(3))
        try:
            self.wait_for(hung, 1)
            yield hung
        finally:
            leave.set()
            if hung.frames:
                left.wait(self.author.patience_s)

    def payloads(self, count: int, first: int = 0) -> list[bytes]:
        """Return that many typical payloads, all different."""
        return [self.author.payload(number) for number in range(first, first + count)]

    def arrives(self, subscriber: RecordingSubscriber, count: int) -> bool:
        """Wait for a total number of frames; return whether they came in time."""
        return self._in_time(lambda limit_s: subscriber.wait_for(count, limit_s))

    def frame_arrives(self, subscriber: RecordingSubscriber, frame: bytes) -> bool:
        """Wait for the given frame; return whether it came in time."""
        return self._in_time(lambda limit_s: subscriber.wait_for_frame(frame, limit_s))

    def wait_for(self, subscriber: RecordingSubscriber, count: int) -> None:
        """Wait for a total number of frames."""
        if not self.arrives(subscriber, count):
            seen = f"{len(subscriber.frames)} of {count} frames had arrived"
            raise self.promise.broken(f"{seen} after {self.author.patience_s:g} s{self._why()}")

    def wait_for_bytes(self, transport: GuardedTransport, count: int) -> None:
        """Wait until the transport has read a total number of bytes."""
        self.wait_until(
            lambda: transport.health.received_bytes >= count,
            f"health.received_bytes to reach {count}",
        )

    def wait_for_silence(self, transport: GuardedTransport) -> None:
        """Wait until no more of the sent data arrives."""
        deadline_ns = self.clock.monotonic_ns() + int(self.author.patience_s * 1e9)
        received = -1
        while received != transport.health.received_bytes:
            received = transport.health.received_bytes
            if self.clock.monotonic_ns() > deadline_ns:
                return
            self.clock.sleep(_SILENCE_S)

    def require_frames(self, subscriber: RecordingSubscriber, sent: list[bytes]) -> None:
        """Fail unless exactly these frames have arrived."""
        came = subscriber.frames
        if came != sent:
            at = next(
                (n for n, pair in enumerate(zip(came, sent, strict=False)) if pair[0] != pair[1]),
                min(len(came), len(sent)),
            )
            raise self.promise.broken(
                f"frame {at} of {len(sent)} was {_shown(came, at)} instead of {_shown(sent, at)}"
            )

    def in_background(self, call: Callable[[], object]) -> threading.Thread:
        """Make a call on another thread, and return the thread."""
        thread = threading.Thread(target=call, name="rosbase-kit-background", daemon=True)
        thread.start()
        return thread

    def wait_until(
        self, condition: Callable[[], object], what: str, limit_s: float | None = None
    ) -> None:
        """Wait until the condition holds."""
        limit_s = limit_s or self.author.patience_s
        deadline_ns = self.clock.monotonic_ns() + int(limit_s * 1e9)
        while not condition():
            in_time = self.clock.monotonic_ns() < deadline_ns
            if not in_time:
                raise self.promise.broken(f"waited {limit_s:g} s in vain for {what}{self._why()}")
            self.require_written()
            self.clock.sleep(_LOOK_S)

    def wait_for_loss(self, transport: GuardedTransport) -> None:
        """Wait until the transport has noticed the loss of its device."""
        self.wait_until(
            lambda: transport.state is TransportState.RECONNECTING,
            "health.state to be RECONNECTING once the device is gone",
        )

    def wait_for_return(self, peer: GuardedPeer, subscriber: RecordingSubscriber) -> list[bytes]:
        """Send until data flows again and all of it has arrived; return the frames."""
        probe, last = self.probes
        limit_s = self.author.reconnect_limit_s
        deadline_ns = self.clock.monotonic_ns() + int(limit_s * 1e9)
        probes = 0
        while not subscriber.wait_for_frame(probe, _PROBE_S):
            in_time = self.clock.monotonic_ns() < deadline_ns
            self.require(in_time, f"no data {limit_s:g} s after the device was back")
            self.require_written()
            peer.send(probe)
            probes += 1
        peer.send(last)
        arrived = self.frame_arrives(subscriber, last)
        self.require(arrived, "after the first frame since the device was back no other arrived")
        came = subscriber.frames
        is_so = came.count(last) == 1 and came.count(probe) <= probes
        self.require(is_so, "since the device was back frames came twice")
        subscriber.clear()
        return came

    def flood(self, peer: GuardedPeer, payloads: list[bytes]) -> Flood:
        """Make the peer send as fast as it can, until the flood is ended."""
        # An error in sending shows here, and not on another thread.
        peer.send(payloads[0])
        return Flood(peer.made.send, payloads)

    def require_written(self) -> None:
        """Fail if the log has a NotImplementedError."""
        for record in self.log.records:
            error = record.exc_info[1] if record.exc_info else None
            if isinstance(error, NotImplementedError):
                raise CALLS.broken(not_written("what the thread of the transport calls", error))

    def close(self) -> None:
        """Close all that the check has made."""
        # Peers first: this ends calls that wait for them.
        for peer in self._peers:
            try:
                peer.close()
            except BrokenPromiseError:
                # The check has already reported.
                pass
        for transport in self._transports:
            transport.release()
        self.log.close()

    def _in_time(self, arrives: Callable[[float], bool]) -> bool:
        """Wait in small steps, because an unimplemented call never delivers."""
        deadline_ns = self.clock.monotonic_ns() + int(self.author.patience_s * 1e9)
        while not arrives(_PROBE_S):
            self.require_written()
            if self.clock.monotonic_ns() > deadline_ns:
                return False
        return True

    def _why(self) -> str:
        """Return the errors that the transports report."""
        errors = {transport.health.last_error for transport in self._transports} - {""}
        return "".join(f"; health.last_error: {error}" for error in sorted(errors))

    def _check_abilities(self, peer: GuardedPeer) -> None:
        kind = type(peer.made).__name__
        for capability, abilities in ABILITIES.items():
            for ability in abilities if getattr(self.author.capabilities, capability) else ():
                PEER_ABILITIES.require(
                    callable(getattr(peer.made, ability, None)),
                    f"{capability} is declared, and {kind} has no {ability}(): "
                    f"write it, or do not declare {capability}",
                )


def _shown(frames: list[bytes], at: int) -> str:
    if at >= len(frames):
        return "nothing"
    frame = frames[at]
    return repr(frame) if len(frame) <= 80 else f"{frame[:40]!r}... ({len(frame)} bytes)"


def _made(make: Callable[[], object], promise: Promise, name: str) -> object:
    """Return the author's object, or break the promise that it is made."""
    try:
        made = make()
    except BrokenPromiseError:
        raise
    except NotImplementedError as error:
        raise promise.broken(not_written(name, error)) from error
    except Exception as error:
        raise promise.broken(raised(name, error)) from error
    promise.require(made is not None, f"{name} gave None: does it return what it makes?")
    return made
