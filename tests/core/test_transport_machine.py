"""A history that the state machine may take by chance, taken on purpose."""

import time

from rosbase.contracts.transport import SimulatedDevice, Transport, TransportContext
from rosbase.testing.transport_kit.bench import Bench
from rosbase.testing.transport_kit.machine import Machine
from rosbase.testing.transport_kit.promises import CALLS
from support.fifo import FifoContract, FifoDevice, make_transport


class SlowDevice(FifoDevice):
    """Reads less than is sent, as on a busy machine."""

    def read(self) -> bytes:
        data = super().read()
        time.sleep(0.01)
        return data


class OfASlowDevice(FifoContract):
    # Leaves the pipe full to the last byte, until there is somebody who reads.
    junk = (b"x" * (65_536 + 4_096),)

    def make_transport(self, peer: SimulatedDevice, context: TransportContext) -> Transport:
        return make_transport({"wait": False, **peer.parameters}, context, device=SlowDevice)


def test_junk_that_nobody_reads_any_more_is_not_held_against_a_slow_device() -> None:
    contract = OfASlowDevice()
    contract.setup_method()
    machine = Machine(Bench(contract, CALLS), [])
    try:
        for step in (machine.start, machine.junk, machine.stop, machine.data, machine.start):
            step()
    finally:
        machine.teardown()
        contract.teardown_method()
