"""The mark that identifies the descendants of a child if no other record of them is left.

Each run of a child has its own mark, in the environment of its guardian, and so of all
descendants. A manager that is a child itself adds its marks to those that it has inherited. So the
variable holds one or more marks, the outermost first. The label of the innermost is in the limits
of the descendants too; see `guardian.py`.
"""

import os
import re
import sys
import zlib
from collections.abc import Mapping
from urllib.parse import quote, unquote

from attrs import frozen

from rosbase.processes.guardian import MARK_VARIABLE, stat_of
from rosbase.processes.proc import began_at

__all__ = ["Mark", "Marks", "label_in", "marked_environment", "marks_in", "program_identity"]

# No real limit of file locks is as large. Below that bit: some of the program, then the life.
_LABELS = 1 << 60
_PROGRAM_BITS = 20
_LIFE_BYTES = 5
_LIMIT = re.compile(rb"^Max file locks +(\d+)", re.MULTILINE)


@frozen
class Mark:
    """One run of a child: its name, its manager and its program."""

    label: int
    """Unique number of this run."""
    manager: tuple[int, int]
    """Process id of the manager, and its start time in the ticks of proc(5)."""
    program: str
    """Program, as `program_identity` names it."""
    name: str
    """Name of the child."""

    def __str__(self) -> str:
        """Return the mark as written in the environment: without white space."""
        pid, began = self.manager
        return f"{self.label:x}.{pid}.{began}.{self.program}.{quote(self.name, safe='')}"


class Marks:
    """Makes the marks of this manager's children."""

    def __init__(self) -> None:
        self.program = program_identity()
        """Program that runs here."""
        stat = stat_of(os.getpid())
        self._manager = (os.getpid(), began_at(stat) if stat else 0)

    def make(self, name: str) -> Mark:
        """Return a mark with a new label, for a child of that name."""
        life = int.from_bytes(os.urandom(_LIFE_BYTES), "big")
        return Mark(_labels_of(self.program) | life, self._manager, self.program, name)


def marked_environment(mark: Mark, environment: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return an environment with the mark added to the marks of this process.

    Args:
        mark: The mark.
        environment: The environment; by default this process's.
    """
    inherited = os.environ.get(MARK_VARIABLE, "").split()
    marks = " ".join([*inherited, str(mark)])
    return {**(os.environ if environment is None else environment), MARK_VARIABLE: marks}


def marks_in(environment: bytes) -> list[Mark]:
    """Return the marks in an environment as proc(5) shows it: texts that end with a NUL."""
    start = f"{MARK_VARIABLE}=".encode()
    if start not in environment:
        return []
    value = next((text for text in environment.split(b"\0") if text.startswith(start)), start)
    found = []
    for text in value[len(start) :].decode(errors="replace").split():
        try:
            label, pid, began, program, name = text.split(".", 4)
            found.append(Mark(int(label, 16), (int(pid), int(began)), program, unquote(name)))
        except ValueError:
            # Somebody else's idea of a mark.
            continue
    return found


def label_in(limits: bytes, program: str = "") -> int | None:
    """Return the label in the limits of a process as proc(5) shows them, if there is one.

    Args:
        limits: The limits.
        program: If given, only a label of that program counts.
    """
    found = _LIMIT.search(limits)
    label = int(found[1]) if found else 0
    wanted = _labels_of(program) if program else _LABELS
    bits = 8 * _LIFE_BYTES if program else _LABELS.bit_length() - 1
    return label if label >> bits == wanted >> bits else None


def program_identity() -> str:
    """Return a short name for the program that runs here: the same at every start.

    It is made from the path of the main module, or from the command line if there is no such
    module. It also contains the namespace of process ids, because a container counts its own.
    """
    main = getattr(sys.modules.get("__main__"), "__file__", None)
    program = os.path.realpath(main) if main else "\0".join(sys.orig_argv)
    try:
        namespace = os.readlink("/proc/self/ns/pid")
    except OSError:
        namespace = ""
    return f"{zlib.crc32(f'{namespace} {program}'.encode(errors='replace')):08x}"


def _labels_of(program: str) -> int:
    """Return the part of a label that all children of a program share."""
    return _LABELS | int(program, 16) % (1 << _PROGRAM_BITS) << 8 * _LIFE_BYTES
