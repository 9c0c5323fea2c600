"""A pseudo-terminal for a child that behaves differently when its output is a pipe."""

import os
import struct
import sys

if sys.platform != "win32":
    import fcntl
    import termios

__all__ = ["open_terminal"]

_OUTPUT, _LOCAL = 1, 3
# What some programs ask before they fold lines, or draw a bar as wide as the screen.
_ROWS, _COLUMNS = 24, 120


def open_terminal() -> tuple[int, int]:
    """Open a pseudo-terminal that passes output through unchanged.

    Returns:
        The descriptor to read from, and the one that the child writes to.
    """
    read_end, write_end = os.openpty()
    try:
        modes = termios.tcgetattr(write_end)
        modes[_OUTPUT] &= ~termios.OPOST
        modes[_LOCAL] &= ~termios.ECHO
        termios.tcsetattr(write_end, termios.TCSANOW, modes)
        # Rows, columns, and a size in pixels, which nobody asks for.
        size = struct.pack("HHHH", _ROWS, _COLUMNS, 0, 0)
        fcntl.ioctl(write_end, termios.TIOCSWINSZ, size)
    except BaseException:
        os.close(read_end)
        os.close(write_end)
        raise
    return read_end, write_end
