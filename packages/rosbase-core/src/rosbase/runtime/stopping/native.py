"""Signal handlers that a C library has installed, such as rclpy's, of which Python does not know.

`signal.getsignal` and `signal.signal` see Python's own table alone: what is put back with them
takes the place of the library's handler.
"""

import ctypes
import os

__all__ = ["is_same_handler", "read_handler", "write_handler"]

# More than a `struct sigaction` has anywhere. It is copied and never looked into.
_MOST_BYTES = 512


def read_handler(signum: int) -> bytes:
    """Return what the system has for a signal; empty where it cannot be asked."""
    found = ctypes.create_string_buffer(_MOST_BYTES)
    return found.raw if _sigaction(signum, None, found) else b""


def write_handler(signum: int, handler: bytes) -> None:
    """Put back what `read_handler` has given."""
    if handler:
        _sigaction(signum, handler, None)


def is_same_handler(one: bytes, other: bytes) -> bool:
    """Tell whether two are the same function, whatever their flags and masks."""
    size = ctypes.sizeof(ctypes.c_void_p)
    return one[:size] == other[:size]


def _sigaction(signum: int, new: bytes | None, old: object) -> bool:
    if os.name != "posix":
        return False
    return bool(ctypes.CDLL(None).sigaction(signum, new, old) == 0)
