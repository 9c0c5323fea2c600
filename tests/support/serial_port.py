"""A serial port that can be plugged in and unplugged, under one name."""

from collections.abc import Mapping
from pathlib import Path

from imu_serial.simulator import PtyDevice
from rosbase.errors import TransportError
from rosbase.parameters import ParameterValue


class PluggablePort:
    """A link to a pseudo-terminal that comes and goes, as udev's `by-id` links do."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "usb-IMU_0001-if00-port0"
        self._device: PtyDevice | None = None

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        return {"device_path": str(self.path)}

    def plug(self) -> None:
        self._device = PtyDevice()
        self.path.symlink_to(str(self._device.parameters["device_path"]))

    def unplug(self) -> None:
        if self._device is not None:
            self.path.unlink()
            self._device.close()
            self._device = None

    def write(self, data: bytes) -> None:
        if self._device is None:
            raise TransportError("the port is not plugged in")
        self._device.write(data)

    @property
    def real_path(self) -> str:
        return str(self.path.resolve())


class SerialPeer(PluggablePort):
    """Plays the device for the contract."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.plug()

    replug = PluggablePort.plug
    close = PluggablePort.unplug
    send_raw = PluggablePort.write

    def send(self, payload: bytes) -> None:
        self.write(self.encode(payload))

    def encode(self, payload: bytes) -> bytes:
        return payload + b"\r\n"
