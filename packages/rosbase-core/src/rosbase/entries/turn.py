"""The turn: the right of one thread to run the program."""

import threading
from threading import get_ident

__all__ = ["Turn"]

_FOR_EVER = -1
_NOBODY = 0


class Turn:
    """A lock that knows its holder. The thread that holds it is inside the program."""

    __slots__ = ("_is_wanted", "_lock", "owner")

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self.owner = _NOBODY
        """Identifier of the thread that holds it; 0 for none."""
        # A thread waits for it, such as the main loop, and goes before all that only try.
        self._is_wanted = False

    @property
    def is_mine(self) -> bool:
        """Whether the calling thread holds the turn."""
        return self.owner == get_ident()

    def acquire(self, timeout_s: float = _FOR_EVER) -> bool:
        """Take the turn; return whether it was free in time. The holder must not ask again."""
        if not self._lock.acquire(blocking=False):
            self._is_wanted = True
            is_free = self._lock.acquire(timeout=timeout_s)
            self._is_wanted = False
            if not is_free:
                return False
        self.owner = get_ident()
        return True

    def try_acquire(self) -> bool:
        """Take the turn if it is free and nobody waits for it; return whether it was."""
        if self._is_wanted or not self._lock.acquire(blocking=False):
            return False
        self.owner = get_ident()
        return True

    def release(self) -> None:
        """Let others have the turn. Only the holder may do so."""
        self.owner = _NOBODY
        self._lock.release()

    def take_over(self) -> None:
        """Take the turn from the thread that built the program, which does not run it."""
        if not self._lock.locked():
            self._lock.acquire()
        self.owner = get_ident()

    def forget(self) -> None:
        """Free it, in a forked child, where its holder may not exist."""
        self._lock = threading.Lock()
        self.owner, self._is_wanted = _NOBODY, False
