"""A simulated serial device: the far end of a pseudo-terminal pair."""

import fcntl
import os
import select
import struct
import tempfile
import termios
import threading
import tty
from collections.abc import Mapping
from pathlib import Path

from rosbase import ParameterValue, TransportError

__all__ = ["PluggablePort", "PtyDevice", "SimulatedPort"]

_POLL_MS = 100
# Half of what a terminal keeps for whoever reads it (N_TTY_BUF_SIZE of Linux).
_ROOM_BYTES = 2_048


class PtyDevice:
    """A device on a line of the kernel: the reader opens it like any other port."""

    def __init__(self) -> None:
        """Create the line and give it a name."""
        self._fd, far_end = os.openpty()
        # Held open, so that the line outlives readers that come and go.
        self._far_end = far_end
        tty.setraw(far_end)
        os.set_blocking(self._fd, False)
        self._path = os.ttyname(far_end)
        self._lock = threading.Lock()
        self._is_closed = False

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """Parameters with which the transport `serial` reaches this device."""
        return {"device_path": self._path}

    def send(self, payload: bytes) -> None:
        """Send one line, CR LF at its end. Wait while the line is full.

        Raises:
            TransportError: The line has been closed.
        """
        self.write(payload + b"\r\n")

    def write(self, data: bytes) -> None:
        """Send raw bytes. Wait while the line is full.

        Raises:
            TransportError: The line has been closed.
        """
        while data:
            data = data[self._write_some(data) :]

    @property
    def has_room(self) -> bool:
        """Whether the device would take a line now: the reader has read most of the others."""
        with self._lock:
            if self._is_closed:
                return False
            unread = fcntl.ioctl(self._far_end, termios.FIONREAD, bytes(4))
        return int(struct.unpack("i", unread)[0]) < _ROOM_BYTES

    def close(self) -> None:
        """Pull the plug."""
        with self._lock:
            if not self._is_closed:
                self._is_closed = True
                os.close(self._far_end)
                os.close(self._fd)

    def _write_some(self, data: bytes) -> int:
        with self._lock:
            if self._is_closed:
                raise TransportError(f"{self._path} has been closed")
            try:
                return os.write(self._fd, data)
            except BlockingIOError:
                fd = self._fd
        # Not under the lock, so that `close` need not wait; it is noticed the next time round.
        ready = select.poll()
        ready.register(fd, select.POLLOUT)
        ready.poll(_POLL_MS)
        return 0


class PluggablePort:
    """A port that comes and goes under one name, as the `by-id` links of udev do."""

    def __init__(self, path: Path) -> None:
        """Choose the name. Nothing is plugged in yet."""
        self.path = path
        """Name of the port."""
        self._device: PtyDevice | None = None

    @property
    def parameters(self) -> Mapping[str, ParameterValue]:
        """Parameters with which the transport `serial` reaches this device."""
        return {"device_path": str(self.path)}

    @property
    def has_room(self) -> bool:
        """Whether the device would take a line now, without waiting for the reader."""
        device = self._device
        return device is not None and device.has_room

    def replug(self) -> None:
        """Plug it in: the port is there. Idempotent."""
        if self._device is None:
            self._device = device = PtyDevice()
            self.path.symlink_to(str(device.parameters["device_path"]))

    def unplug(self) -> None:
        """Pull the plug: the port is gone. Idempotent."""
        device, self._device = self._device, None
        if device is not None:
            self.path.unlink(missing_ok=True)
            device.close()

    def send(self, payload: bytes) -> None:
        """Send one line, CR LF at its end. Wait while the line is full.

        Raises:
            TransportError: The port is not plugged in.
        """
        self._plugged.send(payload)

    def write(self, data: bytes) -> None:
        """Send raw bytes. Wait while the line is full.

        Raises:
            TransportError: The port is not plugged in.
        """
        self._plugged.write(data)

    def close(self) -> None:
        """Pull the plug for good. Idempotent."""
        self.unplug()

    @property
    def _plugged(self) -> PtyDevice:
        if self._device is None:
            raise TransportError(f"{self.path} is not plugged in")
        return self._device


class SimulatedPort(PluggablePort):
    """A port with its own name, plugged in: a `rosbase.PluggableDevice`."""

    def __init__(self) -> None:
        """Plug it in, in a new temporary folder."""
        self._folder = tempfile.TemporaryDirectory(prefix="imu-")
        super().__init__(Path(self._folder.name) / "ttyIMU")
        self.replug()

    def close(self) -> None:
        """Pull the plug for good. Idempotent."""
        super().close()
        self._folder.cleanup()
