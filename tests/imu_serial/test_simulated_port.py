"""The simulated port of `rosbase demo`: a plug that can be pulled and put back."""

import os
from pathlib import Path

import pytest
import serial

from imu_serial.simulator import SimulatedPort
from rosbase import PluggableDevice, TransportError
from support.waiting import wait_until


def test_it_comes_back_under_the_same_name() -> None:
    device = SimulatedPort()
    assert isinstance(device, PluggableDevice)
    path = str(device.parameters["device_path"])
    for _ in range(3):
        with serial.Serial(path, timeout=10) as port:
            device.send(b"1")
            assert port.read_until(b"\n") == b"1\r\n"
        device.unplug()
        device.unplug()
        assert not os.path.lexists(path)
        with pytest.raises(TransportError, match="is not plugged in"):
            device.send(b"1")
        assert not device.has_room
        device.replug()
        device.replug()
    device.close()
    device.close()
    assert not Path(path).parent.exists()


def test_there_is_room_as_long_as_somebody_reads() -> None:
    device = SimulatedPort()
    with serial.Serial(str(device.parameters["device_path"]), timeout=10) as port:
        for _ in range(3):
            assert device.has_room
            for _ in range(30):
                device.send(b"x" * 98)
            # The kernel hands the bytes over to the far end a moment later.
            wait_until(lambda: not device.has_room, "a line that is full")
            assert len(port.read(3_000)) == 3_000
            wait_until(lambda: device.has_room, "a line that is empty")
    device.close()
