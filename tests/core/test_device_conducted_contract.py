"""A transport of a recorded program keeps every promise of a transport."""

from collections.abc import Mapping
from typing import Any

import pytest

from rosbase.contracts.transport import Transport, TransportContext
from rosbase.device.conducted import conducted_transport
from rosbase.entries.recorder import Recorder
from rosbase.parameters import ParameterValue
from rosbase.plugins import TransportPlugin
from support.fifo import PARAMETERS, FifoContract, make_transport

pytestmark = pytest.mark.once


class Idle(Recorder):
    """A recorder of a program that sleeps, whose file takes all at once."""

    def come_in(self, *args: Any) -> None:
        super().come_in(*args)
        # As the main loop does when it is woken.
        if self.has_waiting and self.turn.try_acquire():
            self.bring_in()
            self.turn.release()
        self.trace.take()


def make_recorded(values: Mapping[str, ParameterValue], context: TransportContext) -> Transport:
    recorder = Idle(context.clock)
    transport = conducted_transport(
        recorder, "fifo", lambda inner: make_transport(values, inner), context
    )
    # The program sleeps all the time, so frames come in on the reader thread.
    recorder.turn.release()
    return transport


class TestRecordedTransport(FifoContract):
    reconnect_limit_s = 2.0

    def plugin(self) -> TransportPlugin:
        return TransportPlugin("fifo", "a recorded pipe", make_recorded, PARAMETERS)
