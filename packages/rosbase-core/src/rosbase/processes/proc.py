"""Processes of this machine from proc(5); empty where the system has none."""

import os

from rosbase.processes.guardian import stat_of

__all__ = ["began_at", "everybody", "parent_in", "read_of"]

_PARENT, _BEGAN = 1, 19


def everybody() -> dict[int, list[bytes]]:
    """Return the `stat_of` result of every process, including zombies."""
    try:
        names = os.listdir("/proc")
    except OSError:
        # Another system, or no descriptor is left for looking.
        return {}
    stats = {int(name): stat_of(name) for name in names if name.isdigit()}
    return {pid: stat for pid, stat in stats.items() if stat is not None}


def parent_in(stat: list[bytes]) -> int:
    """Return the parent of a process, from the result of `stat_of`."""
    return int(stat[_PARENT])


def began_at(stat: list[bytes]) -> int:
    """Return the start time of a process in ticks since the boot, from the result of `stat_of`.

    Process ids are used again; together with the start time they are unique.
    """
    return int(stat[_BEGAN])


def read_of(pid: int, name: str) -> bytes:
    """Return a file of a process; empty if it has ended, or belongs to another user."""
    try:
        with open(f"/proc/{pid}/{name}", "rb") as file:
            return file.read()
    except OSError:
        return b""
