import threading

import pytest
import serial

from imu_serial.simulator import PtyDevice
from rosbase.errors import TransportError


def test_what_is_sent_arrives_at_the_named_port_as_a_line() -> None:
    device = PtyDevice()
    with serial.Serial(str(device.parameters["device_path"]), timeout=10) as port:
        device.send(b'{"a":1}')
        assert port.read_until(b"\n") == b'{"a":1}\r\n'
    device.close()


def test_closing_ends_a_send_that_waits() -> None:
    device = PtyDevice()
    ended: list[TransportError] = []

    def fill() -> None:
        try:
            device.write(b"x" * 10_000_000)
        except TransportError as error:
            ended.append(error)

    thread = threading.Thread(target=fill)
    thread.start()
    device.close()
    device.close()
    thread.join(10)
    assert len(ended) == 1
    with pytest.raises(TransportError, match="closed"):
        device.send(b"x")
