"""A domain of ROS for tests and benchmarks."""

import fcntl
import os
import random
import tempfile
from contextlib import suppress
from pathlib import Path

__all__ = ["own_domain"]


def own_domain() -> int:
    """A random domain that no other test or benchmark has; the one behind it is free, too.

    It belongs to this process until its end. Others on the same machine find it taken.
    """
    numbers = list(range(2, 100, 2))
    random.SystemRandom().shuffle(numbers)
    for number in numbers:
        path = Path(tempfile.gettempdir(), f"rosbase-tests-domain-{number}")
        with suppress(OSError):
            if _is_locked(os.open(path, os.O_CREAT | os.O_RDWR)):
                return number
    raise RuntimeError("other tests have all domains of ROS")


def _is_locked(file: int) -> bool:
    """Locks a file for as long as this process lives; returns False if another one has it."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(file)
        return False
    return True
