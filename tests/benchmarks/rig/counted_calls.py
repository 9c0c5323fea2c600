"""The CPU of one end of a service, from one call to another."""

import time
from collections.abc import Callable

__all__ = ["CountedCalls"]


class CountedCalls:
    """Counts the calls of a process; after the last one, prints what they took.

    That is the CPU in nanoseconds of all its threads, the system's part included, and, of a
    client, how long each call lasted.
    """

    def __init__(self, warm_up: int, calls: int) -> None:
        """Takes how many calls come first, and how many are then measured."""
        self._warm_up, self._all = warm_up, warm_up + calls
        self._count = 0
        self._before_ns = 0
        self._lasted_ns: list[int] = []

    @property
    def are_done(self) -> bool:
        """Whether the last one was counted."""
        return self._count >= self._all

    def count(self) -> None:
        """Counts a call."""
        self._count += 1
        if self._count == self._warm_up:
            self._before_ns = time.process_time_ns()
        if self._count == self._all:
            cpu_ns = time.process_time_ns() - self._before_ns
            print(cpu_ns, *self._lasted_ns[self._warm_up :], flush=True)

    def make(self, call: Callable[[], object]) -> None:
        """Makes a call, and counts it."""
        begin_ns = time.monotonic_ns()
        call()
        self._lasted_ns.append(time.monotonic_ns() - begin_ns)
        self.count()
