"""Resources of a process: threads, descriptors, memory."""

import os
import threading
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

__all__ = ["cpu_s", "descriptors", "memory_growth", "threads", "wanted_cpu_s"]

_NS_PER_S = 1_000_000_000
_TASKS = Path("/proc/self/task")
_LISTINGS = (Path("/proc/self/fd"), Path("/dev/fd"))


def threads() -> set[threading.Thread]:
    """Return the running threads, without the kit's own."""
    return {t for t in threading.enumerate() if not t.name.startswith("rosbase-kit")}


def cpu_s() -> float:
    """Return the processor time of this process so far, in seconds."""
    used = os.times()
    return used.user + used.system


def wanted_cpu_s() -> float:
    """Return how long the other threads have run or waited for a processor so far, in seconds.

    A busy loop does one or the other all the time, even on a busy machine. Only Linux counts the
    waiting; on other systems, this is the processor time of the process.
    """
    own, lines = str(threading.get_native_id()), []
    for task in _TASKS.glob("*"):
        # A thread may end at any time.
        with suppress(OSError):
            lines.append((task / "schedstat").read_text() if task.name != own else "")
    if not lines:
        return cpu_s()
    # Time on a processor, and time in its queue.
    return sum(int(ns) for line in lines for ns in line.split()[:2]) / _NS_PER_S


def descriptors() -> int:
    """Return the number of open descriptors; 0 if the system does not tell."""
    for listing in _LISTINGS:
        if listing.exists():
            return len(os.listdir(listing))
    return 0


@contextmanager
def memory_growth() -> Iterator[Callable[[], int]]:
    """Return a function that gives the growth of Python's memory since then, in bytes."""
    was_tracing = tracemalloc.is_tracing()
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    try:
        yield lambda: tracemalloc.get_traced_memory()[0] - before
    finally:
        if not was_tracing:
            tracemalloc.stop()
