"""The settings of a serial line in the kernel: termios, and the requests of drivers.

If a driver does not offer something, the return value says so; there is no exception. A
pseudo-terminal offers only the settings.
"""

import array
import fcntl
import struct
import termios
from collections.abc import Mapping

from imu_serial.config import OFF, ON

__all__ = [
    "ask_for_low_latency",
    "error_counts",
    "exclude_others",
    "excludes_others",
    "set_lines",
    "set_up",
]

# <asm-generic/ioctls.h>; Python's termios has some of them only.
_TCGETS2, _TCSETS2 = 0x802C542A, 0x402C542B
_TIOCGEXCL = 0x80045440
_TIOCGICOUNT = 0x545D
_BOTHER = 0o010000
_INPUT_RATE_SHIFT = 16
# <linux/tty_flags.h>
_ASYNC_LOW_LATENCY = 0x2000
# UARTs understand each other up to some 2 %; what a driver rounds is within that.
_MOST_DEVIATION = 0.05

_COUNTED = {
    "framing_error": 6,
    "overrun": 7,
    "parity_error": 8,
    "line_break": 9,
    "buffer_overrun": 10,
}
"""Index of the count in the kernel's `serial_icounter_struct`, by reason."""


def set_up(fd: int, baudrate: int) -> None:
    """Set a terminal to raw bytes, 8N1, at a rate, and to leave DTR and RTS alone when it closes.

    Raises:
        termios.error: It is not a terminal.
        ValueError: It does not run at that rate.
    """
    cc = termios.tcgetattr(fd)[6]
    # One byte is enough to be read, and none is an error and not an empty result: so the end
    # of a line that was unplugged differs from a byte that somebody else has taken.
    cc[termios.VMIN], cc[termios.VTIME] = 1, 0
    # Without HUPCL, closing does not lower DTR, so the next opening does not raise it.
    cflag = termios.CS8 | termios.CREAD | termios.CLOCAL
    usual = getattr(termios, f"B{baudrate}", None)
    rate = termios.B38400 if usual is None else usual
    termios.tcsetattr(fd, termios.TCSANOW, [0, 0, cflag, 0, rate, rate, cc])
    if usual is None:
        _set_unusual_rate(fd, baudrate)
    _check_rate(fd, baudrate)


def _set_unusual_rate(fd: int, baudrate: int) -> None:
    settings = array.array("I", [0] * 64)
    try:
        fcntl.ioctl(fd, _TCGETS2, settings)
        settings[2] &= ~(termios.CBAUD | termios.CBAUD << _INPUT_RATE_SHIFT)
        settings[2] |= _BOTHER
        settings[9] = settings[10] = baudrate
        fcntl.ioctl(fd, _TCSETS2, settings)
    except OSError as error:
        raise ValueError(f"an unusual rate, which its driver refuses: {error.strerror}") from error


def _check_rate(fd: int, baudrate: int) -> None:
    settings = array.array("I", [0] * 64)
    try:
        fcntl.ioctl(fd, _TCGETS2, settings)
    except OSError:
        return
    actual = settings[10]
    if actual and abs(actual - baudrate) > _MOST_DEVIATION * baudrate:
        raise ValueError(f"it runs at {actual} instead")


def set_lines(fd: int, dtr: str, rts: str) -> bool:
    """Set DTR and RTS as the parameters say; return whether that worked.

    If both lines go off, one request does both: an ESP32 is reset while only one of them is
    on.
    """
    wishes = ((dtr, termios.TIOCM_DTR), (rts, termios.TIOCM_RTS))
    on = sum(bit for wish, bit in wishes if wish == ON)
    off = sum(bit for wish, bit in wishes if wish == OFF)
    try:
        for request, bits in ((termios.TIOCMBIS, on), (termios.TIOCMBIC, off)):
            if bits:
                fcntl.ioctl(fd, request, struct.pack("I", bits))
    except OSError:
        return False
    return True


def ask_for_low_latency(fd: int) -> bool:
    """Ask the driver to hand over bytes at once; return whether it does.

    Otherwise FTDI's waits 16 ms.
    """
    # struct serial_struct; the fifth number are the flags.
    settings = array.array("i", [0] * 32)
    try:
        fcntl.ioctl(fd, termios.TIOCGSERIAL, settings)
        if not settings[4] & _ASYNC_LOW_LATENCY:
            settings[4] |= _ASYNC_LOW_LATENCY
            fcntl.ioctl(fd, termios.TIOCSSERIAL, settings)
    except OSError:
        return False
    return True


def excludes_others(fd: int) -> bool:
    """Return whether a process has asked the kernel to let nobody else open the terminal.

    Root may open it all the same.
    """
    try:
        answer = fcntl.ioctl(fd, _TIOCGEXCL, bytes(4))
    except OSError:
        return False
    return any(answer)


def exclude_others(fd: int, *, excludes: bool) -> None:
    """Ask the kernel to let nobody else open the terminal, or to let them again."""
    try:
        fcntl.ioctl(fd, termios.TIOCEXCL if excludes else termios.TIOCNXCL)
    except OSError:
        # It has been unplugged; there is nothing to keep or to give back.
        pass


def error_counts(fd: int) -> Mapping[str, int] | None:
    """Return how often the driver has seen each kind of error; None if it does not count."""
    try:
        answer = fcntl.ioctl(fd, _TIOCGICOUNT, bytes(80))
    except OSError:
        return None
    numbers = struct.unpack("20i", answer)
    return {reason: numbers[at] for reason, at in _COUNTED.items()}
