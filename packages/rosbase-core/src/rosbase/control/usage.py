"""Resources of the machine that this process uses, as Linux counts them."""

import os
import resource
from typing import Any

from rosbase.clock import SystemClock

__all__ = ["usage"]

_NS_PER_S = 1_000_000_000
# Positions in /proc/<pid>/stat behind the name of the command; see proc_pid_stat(5).
_THREADS, _START, _PAGES = 17, 19, 21


def usage() -> dict[str, Any]:
    """Return start, processor time, memory and threads of this process.

    Without /proc, what it would tell is None.
    """
    used = resource.getrusage(resource.RUSAGE_SELF)
    found: dict[str, Any] = {
        "started_ns": None,
        "cpu_ns": int((used.ru_utime + used.ru_stime) * _NS_PER_S),
        "memory_bytes": None,
        "threads": None,
    }
    try:
        with open("/proc/self/stat", "rb") as file:
            # The name of the command may have blanks and brackets.
            values = file.read().rpartition(b")")[2].split()
    except OSError:
        return found
    clock = SystemClock()
    since_boot_ns = int(values[_START]) * _NS_PER_S // os.sysconf("SC_CLK_TCK")
    booted_ns = clock.now_ns() - clock.monotonic_ns() - clock.suspended_ns()
    return found | {
        "started_ns": booted_ns + since_boot_ns,
        "memory_bytes": int(values[_PAGES]) * os.sysconf("SC_PAGE_SIZE"),
        "threads": int(values[_THREADS]),
    }
