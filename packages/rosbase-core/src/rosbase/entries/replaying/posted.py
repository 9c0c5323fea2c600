"""Calls that threads of the user hand to the program while it is replayed."""

from collections import deque
from collections.abc import Callable
from threading import Condition, current_thread

__all__ = ["PostedCalls"]

_PATIENCE_S = 5.0
# A thread that runs ahead of the recording waits.
_MOST = 1000


class PostedCalls:
    """Keeps them until the recording says that it is their turn. Threads are known by name."""

    def __init__(self, patience_s: float = _PATIENCE_S) -> None:
        """Start without calls.

        Args:
            patience_s: How long to wait for a call, or for room, in seconds of real time.
        """
        self._patience_s = patience_s
        self._calls: dict[str, deque[Callable[[], object]]] = {}
        # Threads that have not called in time: they are waited for once.
        self._late: set[str] = set()
        self._changed = Condition()
        self._is_over = False

    def post(self, call: Callable[[], object]) -> None:
        """Keep a call of the calling thread."""
        name = current_thread().name
        with self._changed:
            if self._is_over:
                return
            calls = self._calls.setdefault(name, deque())
            calls.append(call)
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._is_over or len(calls) < _MOST, self._patience_s)

    def take(self, thread: str) -> Callable[[], object] | None:
        """Return the next call of a thread; wait for it, but not for ever. None: it did not come.

        Args:
            thread: Name of the thread.
        """
        with self._changed:
            patience_s = 0.0 if self._is_over or thread in self._late else self._patience_s
            if not self._changed.wait_for(lambda: self._calls.get(thread), patience_s):
                self._late.add(thread)
                return None
            call = self._calls[thread].popleft()
            self._changed.notify_all()
            return call

    def close(self) -> None:
        """Let no thread wait any more, and ignore its calls."""
        with self._changed:
            self._is_over = True
            self._calls.clear()
            self._changed.notify_all()
