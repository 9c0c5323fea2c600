"""An open serial port: a `rosbase.ReportingDevice`."""

import fcntl
import os
import select
import termios

from imu_serial.config import LEAVE, SerialConfig
from imu_serial.holders import holder_of
from imu_serial.line import (
    ask_for_low_latency,
    error_counts,
    exclude_others,
    excludes_others,
    set_lines,
    set_up,
)
from imu_serial.refusals import explain, in_use, is_multiplexer, is_name, shown
from imu_serial.rivals import Rivals
from imu_serial.uart import bytes_per_s
from rosbase import DeviceReport, NotADeviceError, TransportError

__all__ = ["Port"]

# What a read of a terminal gives at most (N_TTY_BUF_SIZE of Linux).
_CHUNK_BYTES = 4_096
_REMARKS = {
    "overrun": "lost before the machine had read them (overrun)",
    "buffer_overrun": "lost because nobody read them in time (buffer overrun)",
    "framing_error": "damaged (framing errors), as if sent at another rate than {} baud",
    "parity_error": "damaged (parity errors)",
}


class Port:
    """A port that this process has exclusively, as far as the system allows."""

    def __init__(self, config: SerialConfig) -> None:
        """Open the port, exclusively.

        Raises:
            TransportError: The subclass gives the reason; the message is one line.
        """
        path = config.device_path
        self._path = path
        self._config = config
        self._is_open = self._excludes_others = False
        self._missing_lines = ""
        self.name = f"{shown(path)} at {config.baudrate} baud"
        """Name for the log line when it is opened."""
        if not is_name(path):
            raise NotADeviceError(f"{shown(path)} is not the name of a serial port")
        if is_multiplexer(path):
            raise NotADeviceError(f"{shown(path)} makes pseudo-terminals; it is not a serial port")
        if os.path.isdir(path):
            raise NotADeviceError(f"{shown(path)} is a directory, not a serial port")
        try:
            # Without waiting for a carrier, which three wires do not have.
            self._fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise explain(path, config.baudrate, error) from error
        self._is_open = True
        try:
            self._take()
            self._set_up()
        except (OSError, ValueError, termios.error) as error:
            self.close()
            raise explain(path, config.baudrate, error) from error
        except BaseException:
            self.close()
            raise
        # Read into one buffer: a new one for each chunk, cut to size, would fragment the heap.
        self._buffer = bytearray(_CHUNK_BYTES)
        self._view = memoryview(self._buffer)
        self.bytes_per_s = bytes_per_s(path, config.baudrate)
        """Maximum number of bytes per second, where it is known."""
        self._counts = error_counts(self._fd)
        self._rivals = Rivals(path)

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._fd

    def read(self) -> bytes:
        """Return arrived data, as much as one read of a terminal gives.

        Raises:
            TransportError: The port is gone.
        """
        try:
            size = os.readv(self._fd, [self._buffer])
        except BlockingIOError:
            self._rivals.note()
            return b""
        except OSError as error:
            raise self._lost(os.strerror(error.errno or 0)) from error
        if not size:
            if self._is_hung_up():
                raise self._lost("end of file")
            # Another program has changed the settings, and read what had arrived.
            self._rivals.note()
        return bytes(self._view[:size])

    def discard_input(self) -> None:
        """Discard arrived data that was not read.

        Raises:
            TransportError: The port is gone.
        """
        try:
            termios.tcflush(self._fd, termios.TCIFLUSH)
        except (OSError, termios.error) as error:
            raise self._lost(" ".join(str(part) for part in error.args)) from error

    def report(self, is_quiet: bool) -> DeviceReport:
        """Return whether other programs read it too, and which errors the driver has counted."""
        errors = self._new_errors()
        remarks = [self._missing_lines] if self._missing_lines else []
        self._missing_lines = ""
        for reason, remark in _REMARKS.items():
            if number := errors.get(reason):
                how = remark.format(self._config.baudrate)
                plural = "s" if number > 1 else ""
                remarks.append(f"{shown(self._path)}: {number} character{plural} {how}")
        return DeviceReport(self._rivals.trouble(is_quiet=is_quiet), errors, "; ".join(remarks))

    def close(self) -> None:
        """Release the port. Idempotent."""
        if self._is_open:
            self._is_open = False
            if self._excludes_others:
                exclude_others(self._fd, excludes=False)
            os.close(self._fd)

    def _take(self) -> None:
        """Claim the port for this process, before changing any of its settings."""
        # Not for what is no terminal.
        termios.tcgetattr(self._fd)
        # Root may open what another program has for itself. What nobody has open any more was
        # left behind, by a program that was killed while it had a pseudo-terminal.
        if excludes_others(self._fd) and holder_of(self._path):
            raise in_use(self._path)
        # For programs that ask; the other one holds against those that do not.
        fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        exclude_others(self._fd, excludes=True)
        self._excludes_others = True

    def _set_up(self) -> None:
        config = self._config
        # At once: the kernel raises both lines when a port is opened.
        if not set_lines(self._fd, config.dtr, config.rts):
            wishes = {"dtr": config.dtr, "rts": config.rts}
            named = " and ".join(name for name, wish in wishes.items() if wish != LEAVE)
            self._missing_lines = f"{shown(self._path)} has no modem lines to set for {named}"
        set_up(self._fd, config.baudrate)
        ask_for_low_latency(self._fd)

    def _new_errors(self) -> dict[str, int]:
        """Return the errors since the last call, by reason."""
        before, now = self._counts, error_counts(self._fd) if self._counts else None
        self._counts = now
        if before is None or now is None:
            return {}
        # A driver that begins again has counted what it says.
        grown = {
            reason: number - before[reason] if number >= before[reason] else number
            for reason, number in now.items()
        }
        return {reason: number for reason, number in grown.items() if number}

    def _is_hung_up(self) -> bool:
        line = select.poll()
        line.register(self._fd, select.POLLIN)
        return any(state & (select.POLLHUP | select.POLLERR) for _, state in line.poll(0))

    def _lost(self, why: str) -> TransportError:
        return TransportError(f"{shown(self._path)} was lost: {why}")
