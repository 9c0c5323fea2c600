"""The faults of `rosbase simulate`: the reader makes of each what its summary says."""

import re
from functools import partial

import pytest

from rosbase.imu.simulated_faults import FAULTS
from rosbase.imu.simulator import ImuSimulator, payload_at
from rosbase.messages import Time
from rosbase.parameters import ParameterValue
from rosbase.testing import ManualClock
from support.reader_rig import Rig
from support.waiting import wait_until

SAMPLES, START_S = 600, 1_800_000_000


def played(name: str) -> Rig:
    """A reader to which six seconds of the fault have been played."""
    rig = Rig(frozen_after=2.0).activate()
    fault = FAULTS[name].make()
    for number in range(SAMPLES):
        stamp_ns = START_S * 1_000_000_000 + number * 10_000_000
        for piece in fault(number, payload_at(number / 100, Time.from_nanoseconds(stamp_ns))):
            rig.send(piece, stamp_ns)
    return rig


@pytest.mark.parametrize("name", [name for name in FAULTS if name != "frozen"])
def test_a_fault_is_counted_under_the_reason_that_its_summary_names(name: str) -> None:
    rig = played(name)
    counted = re.search(r"counted as (\w+)", FAULTS[name].summary)
    period = re.search(r"in (\d+)", FAULTS[name].summary)
    assert counted
    expected = SAMPLES // (int(period[1]) if period else 50)
    assert rig.reader.counts.by_reason == {counted[1]: expected}
    if "is dropped" in FAULTS[name].summary or name == "spike":
        assert rig.reader.counts.published == SAMPLES - expected
    else:
        assert rig.reader.counts.published == SAMPLES


def test_a_frozen_sensor_is_a_warning() -> None:
    rig = played("frozen")
    assert rig.reader.counts.published == SAMPLES
    assert rig.reader.check_health().message.startswith("all numbers are the same")


def motion_of(payload: bytes) -> bytes:
    return payload.partition(b'"orientation"')[2]


def has_sent(simulator: ImuSimulator, number: int) -> bool:
    return simulator.sent >= number


class Recorder:
    """A simulated device that keeps what it was given."""

    def __init__(self) -> None:
        self.parameters: dict[str, ParameterValue] = {}
        self.sent: list[bytes] = []
        self.is_read = True
        self.looks = 0

    @property
    def has_room(self) -> bool:
        self.looks += 1
        return self.is_read

    def send(self, payload: bytes) -> None:
        self.sent.append(payload)

    def replug(self) -> None: ...

    def unplug(self) -> None: ...

    def close(self) -> None: ...


def test_a_simulator_that_was_stopped_goes_on_where_it_was() -> None:
    device = Recorder()
    simulator = ImuSimulator(device, 1000.0, ManualClock())
    for number in (10, 20):
        simulator.start()
        simulator.start()
        wait_until(partial(has_sent, simulator, number), "samples")
        simulator.stop()
        simulator.stop()
    assert simulator.sent == len(device.sent)
    for number, payload in enumerate(device.sent):
        assert motion_of(payload) == motion_of(payload_at(number / 1000, Time()))


def test_what_nobody_reads_is_not_sent() -> None:
    device = Recorder()
    simulator = ImuSimulator(device, 1000.0, is_attended=False)
    device.is_read = False
    simulator.start()
    wait_until(lambda: device.looks > 10, "samples that nobody reads")
    assert (simulator.sent, device.sent) == (0, [])
    device.is_read = True
    wait_until(lambda: simulator.sent > 0, "a sample that somebody reads")
    simulator.stop()
    beginnings = {motion_of(payload_at(n / 1000, Time())) for n in range(5)}
    assert motion_of(device.sent[0]) not in beginnings
