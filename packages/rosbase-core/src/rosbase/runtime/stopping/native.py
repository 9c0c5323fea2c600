"""Signal handlers installed by a C library, such as rclpy's, which Python does not know.

`signal.getsignal` and `signal.signal` only use Python's own table. Restoring a handler with them
replaces the library's handler.
"""

import ctypes
import os

__all__ = ["is_same_handler", "read_handler", "write_handler"]

# More than a `struct sigaction` has anywhere. It is copied and never looked into.
_MOST_BYTES = 512


def read_handler(signum: int) -> bytes:
    """Return the system's handler of a signal; empty if it cannot be read."""
    found = ctypes.create_string_buffer(_MOST_BYTES)
    return found.raw if _sigaction(signum, None, found) else b""


def write_handler(signum: int, handler: bytes) -> None:
    """Restore a handler from `read_handler`."""
    if handler:
        _sigaction(signum, handler, None)


def is_same_handler(one: bytes, other: bytes) -> bool:
    """Return whether two handlers are the same function, whatever their flags and masks."""
    size = ctypes.sizeof(ctypes.c_void_p)
    return one[:size] == other[:size]


def _sigaction(signum: int, new: bytes | None, old: object) -> bool:
    if os.name != "posix":
        return False
    return bool(ctypes.CDLL(None).sigaction(signum, new, old) == 0)
