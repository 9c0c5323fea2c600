"""Name the processes that an earlier run of the program has left behind.

When manager and guardians are killed together, as by `killall -9 python3`, nothing ends the
descendants of a child. The next run of the program finds them by their mark.
"""

import logging

from attrs import frozen

from rosbase.processes.guardian import has_ended
from rosbase.processes.journal import Journal
from rosbase.processes.mark import label_in, marks_in
from rosbase.processes.proc import began_at, everybody, parent_in, read_of
from rosbase.text.printable import printable

__all__ = ["Survivor", "find_survivors", "name_survivors"]

_MOST_NAMED = 10
_MOST_OF_A_COMMAND = 80
_GUARDIAN = b"rosbase/processes/guardian.py"
_SOMEBODY = "a child"


@frozen
class Survivor:
    """A process that descends from a child of a dead manager."""

    pid: int
    name: str
    """Name of the child."""
    command: str
    """Command line, as the process shows it."""


def find_survivors(program: str) -> list[Survivor]:
    """Return the processes that earlier runs of a program have left behind.

    Descendants of a running guardian or manager are left out, because it takes care of them.
    """
    alive = {pid: stat for pid, stat in everybody().items() if not has_ended(stat)}
    words = {pid: read_of(pid, "cmdline").split(b"\0") for pid in alive}
    # Who is just ending has no command any more; one whose main thread has ended has none either.
    alive = {pid: stat for pid, stat in alive.items() if any(words[pid]) or stat[0] == b"Z"}
    guarded_for = {pid: manager for pid in alive if (manager := _manager_of(words[pid]))}
    # An orphan's parent is nobody's manager.
    managers = {pid for guardian, pid in guarded_for.items() if parent_in(alive[guardian]) == pid}
    keepers = guarded_for.keys() | managers
    return [
        Survivor(pid, name, _shown(words[pid]))
        for pid in alive
        if (name := _child_of(pid, program, alive)) is not None and not _has(alive, pid, keepers)
    ]


def name_survivors(program: str, journal: Journal) -> None:
    """Log a line about each process that earlier runs of a program have left behind."""
    survivors = find_survivors(program)
    for survivor in survivors[:_MOST_NAMED]:
        text = f"an earlier run has left process {survivor.pid} behind: {survivor.command}"
        journal.write(logging.WARNING, survivor.name, text)
    if len(survivors) > _MOST_NAMED:
        text = f"an earlier run has left {len(survivors) - _MOST_NAMED} more processes behind"
        journal.logger.warning(text)


def _manager_of(words: list[bytes]) -> int:
    """Return the manager of a guardian from the guardian's command line; 0 if it is not one."""
    for place, word in enumerate(words[:-2]):
        if word.endswith(_GUARDIAN) and words[place + 2].isdigit():
            return int(words[place + 2])
    return 0


def _child_of(pid: int, program: str, alive: dict[int, list[bytes]]) -> str | None:
    """Return the name of the dead manager's child from which a process descends, if it does."""
    for mark in marks_in(read_of(pid, "environ")):
        number, began = mark.manager
        if mark.program == program:
            runs = number in alive and began_at(alive[number]) == began
            return None if runs else mark.name
    # The environment may have been cleaned.
    return None if label_in(read_of(pid, "limits"), program) is None else _SOMEBODY


def _has(alive: dict[int, list[bytes]], pid: int, keepers: set[int]) -> bool:
    """Return whether a process is one of the keepers, or descends from one."""
    while pid in alive and pid not in keepers:
        pid = parent_in(alive[pid])
    return pid in keepers


def _shown(words: list[bytes]) -> str:
    return printable(b" ".join(words).decode(errors="replace").strip(), _MOST_OF_A_COMMAND)
