"""Calls that end, or are given up: what the kit tries may hang."""

import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

__all__ = ["Caller", "StillRunningError"]

_END_S = 1.0


class StillRunningError(Exception):
    """A call did not return in time."""


class _Job:
    """A call, and what came of it."""

    def __init__(self, function: Callable[[], Any]) -> None:
        self._function = function
        self.is_done = threading.Event()
        self.result: Any = None
        self.error: BaseException | None = None

    def run(self) -> None:
        try:
            self.result = self._function()
        except BaseException as error:
            # It is raised where the call was asked for.
            self.error = error
        self.is_done.set()


class Caller:
    """Makes calls on one thread, and waits for each only so long.

    After a call that hangs the next one is made on another thread.
    """

    def __init__(self) -> None:
        """Starts the thread."""
        self.threads: set[threading.Thread] = set()
        """All that calls have been made on."""
        self._begin()

    def run(self, function: Callable[[], Any], limit_s: float) -> Any:
        """What the function gives or raises.

        Raises:
            StillRunningError: It has not returned within that many seconds.
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
        """Ends the thread. A call that hangs is left behind."""
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
