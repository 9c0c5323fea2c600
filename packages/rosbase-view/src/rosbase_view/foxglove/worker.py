"""A thread that does what would take too long where it is asked for."""

import threading
from collections import deque
from collections.abc import Callable

from rosbase import background_thread

__all__ = ["Job", "Worker"]


class Job:
    """Something to do."""

    def __init__(self, do: Callable[[], object]) -> None:
        """Keep the function."""
        self._do = do
        self._done = threading.Event()

    def run(self) -> None:
        """Do it."""
        try:
            self._do()
        finally:
            self._done.set()

    def wait(self, timeout_s: float) -> bool:
        """Wait until it is done; return False when the time is over."""
        return self._done.wait(timeout_s)


class Worker:
    """Does one job after the other."""

    def __init__(self, name: str, most: int, on_failure: Callable[[Exception], object]) -> None:
        """Prepare the thread.

        Args:
            name: Name of the thread.
            most: How many jobs wait.
            on_failure: Takes an error that should not happen, with which the thread ends.
        """
        self._most = most
        self._on_failure = on_failure
        self._jobs: deque[Job] = deque()
        self._changed = threading.Condition()
        self._is_closed = False
        self._thread = background_thread(self._run, name)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def add(self, do: Callable[[], object]) -> Job | None:
        """Have something done soon; return None if too many jobs wait. Any thread may do so."""
        job = Job(do)
        with self._changed:
            if self._is_closed or len(self._jobs) >= self._most:
                return None
            self._jobs.append(job)
            self._changed.notify()
        return job

    def close(self) -> None:
        """End the thread after the job at which it is. Idempotent."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()
        if self._thread.ident is not None:
            self._thread.join()

    def _run(self) -> None:
        try:
            while (job := self._next()) is not None:
                job.run()
        except Exception as error:
            self._on_failure(error)

    def _next(self) -> Job | None:
        with self._changed:
            self._changed.wait_for(lambda: self._jobs or self._is_closed)
            return None if self._is_closed else self._jobs.popleft()
