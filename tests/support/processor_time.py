"""Processor time of a command, to compare two commands on the same machine."""

import resource
import subprocess
from collections.abc import Sequence

_TRIES = 5


def least_cpu_s(command: Sequence[str], tries: int = _TRIES) -> float:
    """The least processor seconds of several runs, user and system, descendants included.

    The machine's other work makes a run more expensive, never cheaper.
    """
    return min(_cpu_s(command) for _ in range(tries))


def _cpu_s(command: Sequence[str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=40)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
