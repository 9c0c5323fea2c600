"""What `DeviceTransport` does with a device that does not keep to its few rules."""

from pathlib import Path

import pytest

from rosbase.clock import SystemClock
from rosbase.contracts.transport import TransportContext, TransportState
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
