"""A serial port that can be plugged in and unplugged, under one name."""

from pathlib import Path

from imu_serial.simulator import PluggablePort as NamedPort


class PluggablePort(NamedPort):
    """A port that is not plugged in yet, in a folder of the test."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder / "usb-IMU_0001-if00-port0")

    plug = NamedPort.replug

    @property
    def real_path(self) -> str:
        return str(self.path.resolve())


class SerialPeer(PluggablePort):
    """Plays the device for the contract."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.plug()

    close = PluggablePort.unplug
    send_raw = PluggablePort.write

    def send(self, payload: bytes) -> None:
        self.write(self.encode(payload))

    def encode(self, payload: bytes) -> bytes:
        return payload + b"\r\n"
