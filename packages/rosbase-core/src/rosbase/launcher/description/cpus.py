"""Lists of CPUs as taskset(1) writes them: `7`, `4-5`, `0,2`, `0-6:2`."""

import re

__all__ = ["read_cpus"]

_RANGE = re.compile(r"(\d{1,5})(?:-(\d{1,5})(?::(\d{1,5}))?)?", re.ASCII)


def read_cpus(text: str) -> tuple[int, ...]:
    """Return the numbers of the CPUs, in order.

    Raises:
        ValueError: It is no list of CPUs.
    """
    found: set[int] = set()
    for part in text.split(","):
        match = _RANGE.fullmatch(part.strip())
        if match is None:
            raise ValueError(f"{text!r} is no list of CPUs")
        first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
        if last < first or step < 1:
            raise ValueError(f"{text!r} is no list of CPUs")
        found.update(range(first, last + 1, step))
    return tuple(sorted(found))
