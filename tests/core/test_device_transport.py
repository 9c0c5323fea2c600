"""What `DeviceTransport` does with a device that does not keep to its few rules."""

from pathlib import Path

import pytest

from rosbase.clock import SystemClock
from rosbase.contracts.transport import TransportContext, TransportState
from rosbase.device import DeviceTransport
from rosbase.framing import FrameEvent, Framer, LineFramer
from rosbase.logger import RosbaseLogger
from rosbase.testing import RecordingSubscriber
from support.fifo import FifoDevice, FifoPeer, make_transport
from support.waiting import wait_until


class RaisesAtClose(FifoDevice):
    def close(self) -> None:
        super().close()
        raise OSError(5, "Input/output error")


def test_a_device_that_raises_when_it_is_closed_is_logged_and_opened_again(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    peer, subscriber = FifoPeer(tmp_path), RecordingSubscriber()
    context = TransportContext(SystemClock(), RosbaseLogger("device"))
    values = {**peer.parameters, "wait": False}
    transport = make_transport(values, context, device=RaisesAtClose)
    transport.start(subscriber)
    peer.unplug()
    wait_until(lambda: transport.health.state is TransportState.RECONNECTING, "the loss")
    peer.replug()
    wait_until(lambda: transport.is_open, "the return")
    peer.send(b"again")
    assert subscriber.wait_for(1)
    transport.close()
    assert (transport.is_open, transport.health.state) == (False, TransportState.CLOSED)
    failures = [message for message in caplog.messages if "closing" in message]
    assert len(failures) == 2
    assert all("Input/output error" in message for message in failures)
    peer.close()


class OfBytes:
    """A framer that does not say how many bytes it waits with."""

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        return []

    def reset(self) -> None:
        pass


@pytest.mark.parametrize(("framer", "pending"), [(LineFramer(), 600), (OfBytes(), 0), (None, 0)])
def test_health_says_how_many_bytes_wait_for_an_end_if_the_framer_does(
    tmp_path: Path, framer: Framer | None, pending: int
) -> None:
    peer = FifoPeer(tmp_path)
    context = TransportContext(SystemClock(), RosbaseLogger("device"))
    transport = DeviceTransport(lambda: FifoDevice(str(peer.path)), context, framer=framer)
    transport.start(RecordingSubscriber())
    peer.send_raw(b"ends\n" + b"x" * 600)
    wait_until(lambda: transport.health.received_bytes == 605, "the bytes")
    wait_until(lambda: transport.health.pending_bytes == pending, "those that wait")
    transport.close()
    peer.close()


class OthersAreFaster(FifoDevice):
    """Can be read, as its descriptor says, and gives nothing: somebody else has taken it."""

    reads = 0

    def read(self) -> bytes:
        type(self).reads += 1
        return b""

    def discard_input(self) -> None:
        pass


def test_a_device_that_can_be_read_and_gives_nothing_costs_no_processor(tmp_path: Path) -> None:
    peer = FifoPeer(tmp_path)
    context = TransportContext(SystemClock(), RosbaseLogger("device"))
    values = {**peer.parameters, "wait": False}
    transport = make_transport(values, context, device=OthersAreFaster)
    transport.start(RecordingSubscriber())
    peer.send(b"x")
    wait_until(lambda: OthersAreFaster.reads, "the first read")
    before, begin_ns = OthersAreFaster.reads, context.clock.monotonic_ns()
    wait_until(lambda: OthersAreFaster.reads > before + 20, "some more")
    each_s = (context.clock.monotonic_ns() - begin_ns) / 1e9 / (OthersAreFaster.reads - before)
    assert each_s > 0.0009
    transport.close()
    peer.close()
