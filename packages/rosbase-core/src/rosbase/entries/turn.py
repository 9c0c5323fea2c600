"""The turn: the right of one thread to run the program."""

import threading
from threading import get_ident

__all__ = ["Turn"]

_FOR_EVER = -1
_NOBODY = 0


class Turn:
    """A lock that knows its holder. The thread that holds it is inside the program."""

    __slots__ = ("_lock", "_owner")

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._owner = _NOBODY

    @property
    def is_mine(self) -> bool:
        """Whether the calling thread holds the turn."""
        return self._owner == get_ident()

    def acquire(self, timeout_s: float = _FOR_EVER) -> bool:
        """Take the turn; return whether it was free in time. The holder must not ask again."""
        if not self._lock.acquire(timeout=timeout_s):
            return False
        self._owner = get_ident()
        return True

    def try_acquire(self) -> bool:
        """Take the turn if it is free; return whether it was."""
        if not self._lock.acquire(blocking=False):
            return False
        self._owner = get_ident()
        return True

    def release(self) -> None:
        """Let others have the turn. Only the holder may do so."""
        self._owner = _NOBODY
        self._lock.release()

    def take_over(self) -> None:
        """Take the turn from the thread that built the program, which does not run it."""
        if not self._lock.locked():
            self._lock.acquire()
        self._owner = get_ident()
