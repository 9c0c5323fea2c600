"""Threads that run calls in parallel, as many as are needed at the same time."""

import threading
from collections.abc import Callable
from queue import SimpleQueue

from rosbase import background_thread
from rosbase_ros2.deadline import Deadline

__all__ = ["Workers"]


class Workers:
    """Runs calls on threads that are started when all others are busy, up to a limit.

    Unlike `concurrent.futures`, its threads do not keep the process from ending.
    """

    def __init__(self, name: str, limit: int) -> None:
        """Start without a thread.

        Args:
            name: Name of the threads.
            limit: How many there are at most. Calls wait while all are busy.
        """
        self._name = name
        self._limit = limit
        self._calls: SimpleQueue[Callable[[], object] | None] = SimpleQueue()
        self._threads: list[threading.Thread] = []
        self._lock = threading.Lock()
        # Calls that have been submitted and have not ended.
        self._unfinished = 0

    @property
    def are_current_thread(self) -> bool:
        """Whether the caller runs on one of the threads."""
        return threading.current_thread() in self._threads

    def submit(self, call: Callable[[], object]) -> None:
        """Run a call, which must not raise, as soon as a thread is free.

        Only one thread may submit calls.
        """
        with self._lock:
            self._unfinished += 1
            is_new = len(self._threads) < min(self._unfinished, self._limit)
        self._calls.put(call)
        if is_new:
            thread = background_thread(self._run, self._name)
            self._threads.append(thread)
            thread.start()

    def end(self) -> None:
        """Let every thread end after its call."""
        for _ in self._threads:
            self._calls.put(None)

    def join(self, deadline: Deadline) -> bool:
        """Wait for the end of all threads; return whether they have ended in time."""
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(deadline.left_s)
        return not any(thread.is_alive() for thread in self._threads)

    def _run(self) -> None:
        while (call := self._calls.get()) is not None:
            call()
            with self._lock:
                self._unfinished -= 1
