"""Resources of a process: threads, descriptors, memory."""

import os
import threading
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["cpu_s", "descriptors", "memory_growth", "threads"]

_LISTINGS = (Path("/proc/self/fd"), Path("/dev/fd"))


def threads() -> set[threading.Thread]:
    """Return the running threads, without the kit's own."""
    return {t for t in threading.enumerate() if not t.name.startswith("rosbase-kit")}


def cpu_s() -> float:
    """Return the processor time of this process so far, in seconds."""
    used = os.times()
    return used.user + used.system


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
