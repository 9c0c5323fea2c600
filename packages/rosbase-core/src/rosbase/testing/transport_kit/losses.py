"""Checks with a device that is absent, or lost, and comes back."""

import threading

from rosbase.contracts.transport import TransportState
from rosbase.testing.recording import RecordingSubscriber
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.check import check

__all__ = ["LossChecks"]

_LOSSES = 3
_SILENCES = 2
# The lines: lost, absent, back.
_LINES_EACH = 3


class LossChecks(TransportAuthor):
    """Checks of absent and lost devices."""

    @check("can_be_absent")
    def test_an_absent_device_is_refused_in_one_line(self, bench: Bench) -> None:
        """open and start raise a TransportError of one line that names the absent device."""
        peer = bench.peer()
        transport = bench.transport(peer)
        bench.take_away(peer)
        # open twice: after a failure, the transport must not be half open.
        for name, arguments in (("open", ()), ("open", ()), ("start", (RecordingSubscriber(),))):
            error = transport.refusal(name, *arguments)
            if error is None:
                raise bench.promise.broken(f"{name}() succeeded without a device")
            text = str(error)
            bench.require("\n" not in text, f"{name}() raised several lines: {text!r}")
            names = [str(value) for value in peer.parameters.values()]
            named = any(value in text for value in names if len(value) > 1)
            bench.require(named, f"{name}() raised {text!r}, which names none of {names}")
            last = transport.health.last_error
            bench.require("\n" not in last, f"health.last_error has several lines: {last!r}")
        bench.require(not transport.is_open, "is_open was true without a device")
        state = transport.state
        bench.require(state is TransportState.CLOSED, f"health.state was {state.name}, not CLOSED")

    @check("can_be_absent", "can_unplug")
    def test_open_may_be_tried_again(self, bench: Bench) -> None:
        """After open has failed, it succeeds as soon as the device is present."""
        peer = bench.peer()
        transport = bench.transport(peer)
        peer.unplug()
        transport.refusal("open")
        peer.replug()
        transport.open()
        bench.prove(peer, transport)

    @check("waits_with", "can_unplug")
    def test_an_absent_device_is_waited_for(self, bench: Bench) -> None:
        """If told to wait, open returns without the device and reads it as soon as it appears."""
        peer = bench.peer()
        transport = bench.transport(peer, waits=True)
        peer.unplug()
        subscriber = RecordingSubscriber()
        transport.open()
        transport.start(subscriber)
        state = transport.state
        seen = f"health.state was {state.name}, not RECONNECTING, while it waited"
        bench.require(state is TransportState.RECONNECTING, seen)
        peer.replug()
        bench.wait_for_return(peer, subscriber)
        reconnects = transport.health.reconnects
        seen = f"health.reconnects was {reconnects}: it came late, it did not come back"
        bench.require(reconnects == 0, seen)

    @check("can_unplug")
    def test_a_loss_is_noticed(self, bench: Bench) -> None:
        """When the device is lost, health is RECONNECTING with the reason; is_open is False."""
        peer, transport, _ = bench.reading()
        peer.unplug()
        bench.wait_for_loss(transport)
        bench.require(not transport.is_open, "is_open was true after the loss")
        error = transport.health.last_error
        bench.require(error, "health.last_error was empty after the loss")
        bench.require("\n" not in error, f"health.last_error has several lines: {error!r}")

    @check("can_unplug")
    def test_data_flows_again_after_a_loss(self, bench: Bench) -> None:
        """When the device returns, data flows again by itself, on the same thread, in time."""
        peer = bench.peer()
        transport = bench.transport(peer)
        readers: set[threading.Thread] = set()
        subscriber = RecordingSubscriber(then=lambda *_: readers.add(threading.current_thread()))
        transport.start(subscriber)
        for _ in range(_LOSSES):
            peer.unplug()
            bench.wait_for_loss(transport)
            peer.replug()
            bench.wait_for_return(peer, subscriber)
        bench.require(len(readers) == 1, f"{len(readers)} threads called on_frame after losses")
        state = transport.state
        seen = f"health.state was {state.name} although data flows"
        bench.require(state is TransportState.CONNECTED, seen)

    @check("can_unplug")
    def test_reconnects_are_counted(self, bench: Bench) -> None:
        """health.reconnects counts how often the device was lost and came back."""
        peer, transport, subscriber = bench.reading()
        for times in range(_LOSSES):
            counted = transport.health.reconnects
            bench.require(counted == times, f"it was {counted} after {times} times")
            peer.unplug()
            bench.wait_for_loss(transport)
            peer.replug()
            bench.wait_for_return(peer, subscriber)
        transport.close()
        counted = transport.health.reconnects
        bench.require(counted == _LOSSES, f"it was {counted} after {_LOSSES} times and close")

    @check("is_stream", "can_unplug")
    def test_a_frame_begun_before_a_loss_is_not_continued(self, bench: Bench) -> None:
        """A frame begun before a loss is discarded, not continued with later data."""
        peer, transport, subscriber = bench.reading()
        (begun,) = bench.payloads(1)
        encoded = peer.encode(begun)
        half = encoded[: len(encoded) // 2]
        peer.send_raw(half)
        bench.wait_for_bytes(transport, len(half))
        peer.unplug()
        bench.wait_for_loss(transport)
        peer.replug()
        bench.wait_until(
            lambda: transport.is_open, "the device to be taken again", self.reconnect_limit_s
        )
        came = bench.wait_for_return(peer, subscriber)
        spoiled = [frame for frame in came if frame not in bench.probes]
        bench.require(not spoiled, f"{spoiled!r} came, which nobody sent")

    @check("can_unplug")
    def test_a_loss_is_a_few_lines_in_the_log(self, bench: Bench) -> None:
        """The log has a line for each change, not for each attempt: lost, absent, back."""
        peer, transport, subscriber = bench.reading()
        said = len(bench.log.lines)
        for _ in range(_LOSSES):
            peer.unplug()
            bench.wait_for_loss(transport)
            peer.replug()
            bench.wait_for_return(peer, subscriber)
        lines = bench.log.lines[said:]
        bench.require(lines, "a loss was not logged at all")
        seen = f"{_LOSSES} losses made {len(lines)} lines: {lines[:4]}..."
        bench.require(len(lines) <= _LOSSES * _LINES_EACH, seen)

    @check("reopens_with")
    def test_a_silent_device_is_opened_anew(self, bench: Bench) -> None:
        """If told to, it reopens a silent device until data flows, counts it, and logs it once."""
        peer = bench.peer()
        transport = bench.transport(peer, reopens=True)
        subscriber = RecordingSubscriber()
        transport.start(subscriber)
        said = len(bench.log.lines)
        bench.wait_until(
            lambda: transport.health.reconnects >= _SILENCES,
            f"health.reconnects to reach {_SILENCES} while the device is silent",
        )
        error = transport.health.last_error
        bench.require(error, "health.last_error was empty while the device was silent")
        bench.wait_for_return(peer, subscriber)
        bench.wait_until(
            lambda: not transport.health.last_error, "health.last_error to be empty again"
        )
        lines = bench.log.lines[said:]
        bench.require(lines, "a silent device was not logged at all")
        seen = f"{_SILENCES} times or more made {len(lines)} lines: {lines[:4]}..."
        bench.require(len(lines) <= _LINES_EACH, seen)
