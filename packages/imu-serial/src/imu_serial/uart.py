"""Tell whether a serial port is a UART of this machine, which limits the speed of the bytes."""

import os

__all__ = ["bytes_per_s"]

_TTYS = "/sys/class/tty"
# 8N1: a start bit, eight of data, a stop bit.
_BITS_PER_BYTE = 10


def bytes_per_s(path: str, baudrate: int, ttys: str = _TTYS) -> float | None:
    """Return the maximum number of bytes per second of a port; None if it is not known.

    Only a UART hands over bytes as they come. A USB adapter gathers them for some
    milliseconds. For USB CDC or a pseudo-terminal, a speed means nothing.

    Args:
        path: A device file, or a link to one.
        baudrate: Bits per second.
        ttys: Folder where the kernel describes its terminals.
    """
    name = os.path.basename(os.path.realpath(path))
    # Drivers of UARTs say so, and no others do.
    if not os.path.exists(os.path.join(ttys, name, "uartclk")):
        return None
    return baudrate / _BITS_PER_BYTE
