"""What proc(5) says of the processes of this machine; nothing where there is no such thing."""

import os

from rosbase.processes.guardian import stat_of

__all__ = ["began_at", "everybody", "parent_in", "read_of"]

_PARENT, _BEGAN = 1, 19


def everybody() -> dict[int, list[bytes]]:
    """Return what `stat_of` gives for every process, those that wait to be reaped included."""
    try:
        names = os.listdir("/proc")
    except OSError:
        # Another system, or no descriptor is left for looking.
        return {}
    stats = {int(name): stat_of(name) for name in names if name.isdigit()}
    return {pid: stat for pid, stat in stats.items() if stat is not None}


def parent_in(stat: list[bytes]) -> int:
    """Return the parent of a process, by what `stat_of` gave."""
    return int(stat[_PARENT])


def began_at(stat: list[bytes]) -> int:
    """Return when a process began, in ticks since the machine did, by what `stat_of` gave.

    Process numbers are used again; together with this they are not.
    """
    return int(stat[_BEGAN])


def read_of(pid: int, name: str) -> bytes:
    """Return a file of a process; nothing if it has ended, or belongs to another user."""
    try:
        with open(f"/proc/{pid}/{name}", "rb") as file:
            return file.read()
    except OSError:
        return b""
