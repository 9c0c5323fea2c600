"""A serial port that can be plugged in and unplugged, under one name."""

from pathlib import Path

from imu_serial.simulator import PtyDevice


class PluggablePort:
    """A link to a pseudo-terminal that comes and goes, as udev's `by-id` links do."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "usb-IMU_0001-if00-port0"
        self._device: PtyDevice | None = None

    def plug(self) -> None:
        self._device = PtyDevice()
        self.path.symlink_to(str(self._device.parameters["device_path"]))

    def unplug(self) -> None:
        if self._device is not None:
            self.path.unlink()
            self._device.close()
            self._device = None

    def write(self, data: bytes) -> None:
        assert self._device is not None, "the port is not plugged in"
        self._device.write(data)

    @property
    def real_path(self) -> str:
        return str(self.path.resolve())
