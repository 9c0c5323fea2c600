"""Wait for something that another callback, thread or process does, from any thread."""

import threading
from collections.abc import Callable

from rosbase.clock import SystemClock
from rosbase.runtime.executor import Executor

__all__ = ["Waiting"]

_NS_PER_S = 1_000_000_000
_LONGEST_S = 1e6
# A thread that does not spin is not told of a stop.
_LOOK_S = 0.1


class Waiting:
    """Waits of several threads for the same things. A change wakes all of them."""

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._machine = SystemClock()
        # Replaced under the lock, so that a change needs none.
        self._sleepers: tuple[threading.Event, ...] = ()
        self._lock = threading.Lock()

    def changed(self) -> None:
        """Let all who wait look again. Call it from any thread."""
        self._executor.wake()
        for sleeper in self._sleepers:
            sleeper.set()

    def wait(self, done: Callable[[], object], timeout_s: float) -> None:
        """Wait until `done` returns true, the timeout, or a request to stop.

        It looks often, for things of which nobody tells `changed`. The thread that spins runs
        urgent calls meanwhile. On another one the timeout is in real time too, because nobody may
        be there to move a virtual clock on.
        """
        executor = self._executor
        deadline_ns = executor.clock.monotonic_ns() + int(min(timeout_s, _LONGEST_S) * _NS_PER_S)
        if executor.is_on_own_thread:
            executor.wait(done, deadline_ns, _LOOK_S)
            return
        with executor.let_others():
            self._sleep_until(done, timeout_s, deadline_ns)

    def _sleep_until(self, done: Callable[[], object], timeout_s: float, deadline_ns: int) -> None:
        executor = self._executor
        begin_ns = self._machine.monotonic_ns()
        sleeper = threading.Event()
        with self._lock:
            self._sleepers = (*self._sleepers, sleeper)
        try:
            while not done() and not executor.is_stopping:
                waited_s = (self._machine.monotonic_ns() - begin_ns) / _NS_PER_S
                if waited_s >= timeout_s or executor.clock.monotonic_ns() >= deadline_ns:
                    break
                sleeper.wait(min(timeout_s - waited_s, _LOOK_S))
                sleeper.clear()
        finally:
            with self._lock:
                self._sleepers = tuple(s for s in self._sleepers if s is not sleeper)
