"""An open serial port. The only module that touches pyserial and the file descriptor."""

import errno
import fcntl
import grp
import os
import termios

import serial
from serial.tools import list_ports

from imu_serial.config import SerialConfig
from imu_serial.uart import bytes_per_s
from rosbase import (
    DeviceBusyError,
    DeviceNotFoundError,
    DevicePermissionError,
    NotADeviceError,
    TransportError,
    one_line,
    printable,
)

__all__ = ["Port", "group_name", "port_names"]

# What a read of a terminal gives at most (N_TTY_BUF_SIZE of Linux).
_CHUNK_BYTES = 4_096


class Port:
    """A port that this process has for itself.

    pyserial opens and configures it. Reading goes around pyserial: its `read` and
    `readline` take bytes one by one or several system calls for each chunk.
    """

    def __init__(self, config: SerialConfig) -> None:
        """Opens the port, exclusively.

        Raises:
            TransportError: Which kind says why; the message is one line.
        """
        path = config.device_path
        # Fit for a line of text.
        self._path = printable(path) or repr(path)
        self.name = f"{self._path} at {config.baudrate} baud"
        """What it is called when it is opened."""
        if not path or "\0" in path:
            raise NotADeviceError(f"{self._path} is not the name of a serial port")
        if os.path.isdir(path):
            raise NotADeviceError(f"{self._path} is a directory, not a serial port")
        port = serial.Serial()
        port.port = path
        port.baudrate = config.baudrate
        port.timeout = 0
        port.exclusive = True
        try:
            port.open()
        except (OSError, ValueError, termios.error) as error:
            raise _explain(self._path, path, config.baudrate, error) from error
        self._serial = port
        self._fd: int = port.fileno()
        # Read into one buffer: a new one for each chunk, cut to size, would fragment the heap.
        self._buffer = bytearray(_CHUNK_BYTES)
        self._view = memoryview(self._buffer)
        self.bytes_per_s = bytes_per_s(path, config.baudrate)
        """How many bytes a second come at most, where that is known."""
        self._refuse_others()

    def fileno(self) -> int:
        """The descriptor."""
        return self._fd

    def read(self) -> bytes:
        """What has arrived, as much as one read of a terminal gives.

        Raises:
            TransportError: The port is gone.
        """
        try:
            size = os.readv(self._fd, [self._buffer])
        except BlockingIOError:
            return b""
        except OSError as error:
            raise self._lost(os.strerror(error.errno or 0)) from error
        if not size:
            raise self._lost("end of file")
        return bytes(self._view[:size])

    def discard_input(self) -> None:
        """Forgets what has arrived and was not read.

        Raises:
            TransportError: The port is gone.
        """
        try:
            termios.tcflush(self._fd, termios.TCIFLUSH)
        except (OSError, termios.error) as error:
            raise self._lost(" ".join(str(part) for part in error.args)) from error

    def close(self) -> None:
        """Gives the port back. Idempotent."""
        if self._serial.is_open:
            try:
                fcntl.ioctl(self._fd, termios.TIOCNXCL)
            except OSError:
                # The device has been unplugged; there is nothing left to give back.
                pass
            self._serial.close()

    def _lost(self, why: str) -> TransportError:
        return TransportError(f"{self._path} was lost: {why}")

    def _refuse_others(self) -> None:
        # pyserial's lock is advisory; this one also holds against programs that do not ask.
        try:
            fcntl.ioctl(self._fd, termios.TIOCEXCL)
        except OSError:
            pass


def _explain(name: str, path: str, baudrate: int, error: Exception) -> TransportError:
    """The error that says what a user can do about it."""
    code = getattr(error, "errno", None)
    if code is None and error.args:
        code = error.args[0] if isinstance(error.args[0], int) else None
    match code:
        case errno.ENOENT | errno.ENODEV | errno.ENXIO:
            return DeviceNotFoundError(f"{name} is not there; is the device plugged in?")
        case errno.EACCES | errno.EPERM:
            return DevicePermissionError(
                f"{name} may not be opened by this user; it belongs to the group {group_name(path)}"
            )
        case errno.EAGAIN | errno.EBUSY:
            return DeviceBusyError(f"{name} is in use by another program")
        case errno.ENOTDIR | errno.EISDIR | errno.ELOOP:
            return NotADeviceError(f"{name} is not a serial port")
    text = one_line(str(error))
    if "Inappropriate ioctl" in text:
        return NotADeviceError(f"{name} is not a serial port")
    if isinstance(error, ValueError):
        return NotADeviceError(f"{name} does not take {baudrate} baud: {text}")
    return TransportError(f"{name} cannot be opened: {text}")


def group_name(path: str) -> str:
    """The group that a port belongs to."""
    try:
        return grp.getgrgid(os.stat(path).st_gid).gr_name
    except (OSError, KeyError):
        return "of another user"


def port_names() -> list[str]:
    """The paths of the serial ports that are there; those on the board, which few use, last."""
    names = [port.device for port in list_ports.comports()]
    return sorted(names, key=lambda name: (name.startswith("/dev/ttyS"), name))
