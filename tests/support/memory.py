"""The memory of another process."""

import os
import time
from pathlib import Path

from support.waiting import wait_until

__all__ = ["resident_kb", "worst_growth_kb"]

_PAGE_KB = os.sysconf("SC_PAGE_SIZE") // 1024


def resident_kb(pid: int) -> int:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * _PAGE_KB


def worst_growth_kb(pid: int, seconds: float) -> int:
    """By how much the memory of a process grows at most, within some time."""
    before_kb, until = resident_kb(pid), time.monotonic() + seconds
    worst_kb = 0

    def is_over() -> bool:
        nonlocal worst_kb
        worst_kb = max(worst_kb, resident_kb(pid) - before_kb)
        return time.monotonic() > until

    wait_until(is_over, "the end of the time")
    return worst_kb
