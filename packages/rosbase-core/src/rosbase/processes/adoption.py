"""End the processes that a child leaves behind when its guardian is killed.

The kernel gives orphans to the nearest ancestor that has asked for them. While it has children,
the manager asks too (PR_SET_CHILD_SUBREAPER in prctl(2)). So it gets the processes that a dead
guardian had adopted. It recognises them by their mark. It never waits for any other process, such
as a daemon or a subprocess of the program.
"""

import ctypes
import os
import signal
import sys
import threading

from rosbase.clock import Clock
from rosbase.processes.guardian import has_ended
from rosbase.processes.mark import Mark, label_in, marks_in
from rosbase.processes.proc import everybody, parent_in, read_of

__all__ = ["begin_adopting", "end_adopting", "end_family"]

_PATIENCE_NS = 1_500_000_000
_LOOK_AGAIN_S = 0.01
_LEAST_LOOKS = 4
_PR_SET_CHILD_SUBREAPER, _PR_GET_CHILD_SUBREAPER = 36, 37


class _Adopting:
    """Number of requests that this process adopts orphans. It concerns the whole process."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._asking = 0
        self._was_already = False

    def begin(self) -> None:
        with self._lock:
            if not self._asking:
                self._was_already = _is_subreaper()
                _prctl(_PR_SET_CHILD_SUBREAPER, 1)
            self._asking += 1

    def end(self) -> None:
        with self._lock:
            self._asking -= 1
            if not self._asking and not self._was_already:
                _prctl(_PR_SET_CHILD_SUBREAPER, 0)


_adopting = _Adopting()


def begin_adopting() -> None:
    """Start adopting the orphans among this process's descendants, until `end_adopting`."""
    _adopting.begin()


def end_adopting() -> None:
    """Undo one `begin_adopting`."""
    _adopting.end()


def end_family(mark: Mark, clock: Clock) -> list[int]:
    """Kill every process that carries the mark or descends from it, and reap the dead ones.

    Returns:
        The processes that could not be killed within 1.5 seconds; usually none.
    """
    family = _Family(mark)
    ends_ns = clock.monotonic_ns() + _PATIENCE_NS
    looks = empty_looks = 0
    while True:
        alive = family.look()
        looks += 1
        # The list of processes is not made in one instant, so one empty look is not enough.
        empty_looks = 0 if alive else empty_looks + 1
        # On a busy machine, one look may take all of the time.
        is_late = looks >= _LEAST_LOOKS and clock.monotonic_ns() >= ends_ns
        if empty_looks == 2 or is_late:
            return alive
        for pid in alive:
            try:
                os.kill(pid, signal.SIGKILL)
            except OSError:
                # It has ended meanwhile, or belongs to another user.
                pass
        if alive:
            clock.sleep(_LOOK_AGAIN_S)


class _Family:
    """The processes that carry a mark, and their descendants."""

    def __init__(self, mark: Mark) -> None:
        self._mark = mark
        # A child that is a manager too has its own children carry labels of its own.
        self._labels = {mark.label}

    def look(self) -> list[int]:
        """Reap ended processes that are ours to reap; return the living ones."""
        stats = everybody()
        family = {pid for pid in stats if self._has(pid)}
        while grown := {pid for pid in stats if parent_in(stats[pid]) in family} - family:
            family |= grown
        dead = {pid for pid in family if has_ended(stats[pid])}
        for pid in dead:
            if parent_in(stats[pid]) == os.getpid():
                _reap(pid)
        return sorted(family - dead)

    def _has(self, pid: int) -> bool:
        marks = marks_in(read_of(pid, "environ"))
        if self._mark in marks:
            self._labels |= {mark.label for mark in marks[marks.index(self._mark) :]}
            return True
        # Who has ended and is not reaped yet has no environment any more, but limits.
        return label_in(read_of(pid, "limits")) in self._labels


def _reap(pid: int) -> None:
    try:
        os.waitpid(pid, os.WNOHANG)
    except ChildProcessError:
        # Somebody of this process has been faster.
        pass


def _is_subreaper() -> bool:
    answer = ctypes.c_int()
    _prctl(_PR_GET_CHILD_SUBREAPER, ctypes.byref(answer))
    return bool(answer.value)


def _prctl(option: int, value: object) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)
