"""Whether a serial port is a UART of this machine, whose speed is that of the bytes."""

import os

__all__ = ["bytes_per_s"]

_TTYS = "/sys/class/tty"
# 8N1: a start bit, eight of data, a stop bit.
_BITS_PER_BYTE = 10


def bytes_per_s(path: str, baudrate: int, ttys: str = _TTYS) -> float | None:
    """Return how many bytes a second a port hands over at most; None if nobody can tell.

    Only a UART hands over bytes as they come. An adapter on USB gathers them for some
    milliseconds, and for USB CDC or a pseudo-terminal a speed means nothing at all.

    Args:
        path: A device file, or a link to one.
        baudrate: Bits per second.
        ttys: Where the kernel says what its terminals are.
    """
    name = os.path.basename(os.path.realpath(path))
    # Drivers of UARTs say so, and no others do.
    if not os.path.exists(os.path.join(ttys, name, "uartclk")):
        return None
    return baudrate / _BITS_PER_BYTE
