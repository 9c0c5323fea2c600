"""Calls with a timeout, because the code under test may hang."""

import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

__all__ = ["Caller", "StillRunningError"]

_END_S = 1.0


class StillRunningError(Exception):
    """A call did not return in time."""


class _Job:
    """Call with its result."""

    def __init__(self, function: Callable[[], Any]) -> None:
        self._function = function
        self.is_done = threading.Event()
        self.result: Any = None
        self.error: BaseException | None = None

    def run(self) -> None:
        try:
            self.result = self._function()
        except BaseException as error:
            # The caller's thread raises it.
            self.error = error
        self.is_done.set()


class Caller:
    """Thread that makes calls, with a timeout for each.

    After a call that hangs, the next one is made on another thread.
    """

    def __init__(self) -> None:
        """Start the thread."""
        self.threads: set[threading.Thread] = set()
        """All threads on which calls were made."""
        self._begin()

    def run(self, function: Callable[[], Any], limit_s: float) -> Any:
        """Call the function; return its result or raise its exception.

        Raises:
            StillRunningError: The function has not returned within the timeout.
        """
        job = _Job(function)
        self._jobs.put(job)
        if not job.is_done.wait(limit_s):
            self._jobs.put(None)
            self._begin()
            raise StillRunningError(f"has not returned after {limit_s:g} s")
        if job.error is not None:
            raise job.error
        return job.result

    def close(self) -> None:
        """End the thread. A call that hangs is abandoned."""
        self._jobs.put(None)
        self._thread.join(_END_S)

    def _begin(self) -> None:
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._thread = threading.Thread(
            target=_work, args=(self._jobs,), name="rosbase-kit", daemon=True
        )
        self.threads.add(self._thread)
        self._thread.start()


def _work(jobs: "SimpleQueue[_Job | None]") -> None:
    while (job := jobs.get()) is not None:
        job.run()
