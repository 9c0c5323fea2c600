"""Requests of threads of the user that wait for their result while the program is replayed."""

from collections import deque
from collections.abc import Callable
from threading import Condition
from typing import Any

from rosbase.entries.kinds import Kind

__all__ = ["Entered"]

_PATIENCE_S = 5.0


class Entered:
    """Hands the result of a replayed request to the thread that makes the same one now."""

    kinds: frozenset[int] = frozenset({Kind.CHANGE_STATE})
    """The kinds that return a result."""

    def __init__(self, patience_s: float = _PATIENCE_S) -> None:
        """Start without results.

        Args:
            patience_s: How long a thread waits, in seconds of real time.
        """
        self._patience_s = patience_s
        self._results: dict[int, deque[Any]] = {
            kind: deque(maxlen=1000) for kind in sorted(self.kinds)
        }
        self._changed = Condition()
        self._is_over = False

    def carry_out(self, kind: int, request: Callable[[], object]) -> None:
        """Carry out a request, and keep its result or its error for the thread that makes it."""
        try:
            result, error = request(), None
        except Exception as raised:
            # As when it was recorded, it is the thread's own.
            result, error = None, raised
        with self._changed:
            self._results[kind].append((result, error))
            self._changed.notify_all()

    def wait(self, kind: int) -> Any:
        """Return the next result of a kind, or raise its error.

        Raises:
            RuntimeError: The recording has no such request.
        """
        with self._changed:
            results = self._results.get(kind, ())
            self._changed.wait_for(lambda: results or self._is_over, self._patience_s)
            if not results:
                raise RuntimeError("the replay has no such request: in the recording, none came")
            result, error = results.popleft()
        if error is not None:
            raise error
        return result

    def close(self) -> None:
        """Let no thread wait any more."""
        with self._changed:
            self._is_over = True
            self._changed.notify_all()
