"""The simulated port of `rosbase demo`: a plug that can be pulled and put back."""

import os
from pathlib import Path

import pytest
import serial

from imu_serial.simulator import SimulatedPort
from rosbase import PluggableDevice, TransportError


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
        sent = 0
        while device.has_room:
            device.send(b"x" * 98)
            sent += 100
        assert 2_000 < sent < 4_096, "nothing has waited for it, and no line has been cut"
        assert len(port.read(sent)) == sent
        assert device.has_room
    device.close()
