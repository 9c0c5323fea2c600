"""Run one command, and ensure that none of its processes outlives the manager.

This is a separate script, started as `python -I -S guardian.py CONTROL_FD MANAGER_PID LINK_FD
ARGV...`. It imports only the standard library. LINK_FD is handed on to a node; otherwise it is -1.

Killing a shell leaves its background processes, and killing a group leaves processes that have
left the group. So the guardian adopts every descendant of its command (on Linux, see
PR_SET_CHILD_SUBREAPER in prctl(2)). It ends only when none is left.

It stops the command when the manager says so, and at once when the manager is gone. It reports to
the manager in lines. `started PID` and `failed WHY` report the start, and `ended PID CODE` an end
(negative: that signal). `told NUMBER` means that a signal has asked the guardian itself to stop.
`killed` reports a SIGKILL, and `left PID ...` processes that even SIGKILL did not end.

The guardian may be killed too. The manager must then recognise the processes left behind. So the
guardian sets the label of the mark in its environment (see `mark.py`) as its limit of file locks.
Linux enforces no such limit, but every descendant inherits it. A cleaned environment, another
session or another name does not remove it.
"""

import ctypes
import os
import select
import signal
import sys
import time
from collections.abc import Callable

if sys.platform == "linux":
    import resource

# By number: this module is imported, though not used, where there is no such signal.
SIGKILL = 9
# How long each signal may take, in seconds.
LADDER = ((signal.SIGINT, 2.0), (signal.SIGTERM, 1.0), (SIGKILL, 1.0))
# The same when nobody waits for a proper end any more.
SHORT_LADDER = ((signal.SIGINT, 0.4), (signal.SIGTERM, 0.4), (SIGKILL, 1.0))
PATIENCE_S = sum(seconds for _, seconds in LADDER)
"""Maximum time of a stop."""

# Who is being killed may still start others: look again this often.
_KILL_AGAIN_S = 0.05
_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36
_IS_LINUX = sys.platform == "linux"
_RLIMIT_LOCKS = 10
STOP_VARIABLE = "ROSBASE_STOP_S"
"""Environment variable of a guardian: seconds for the first signal, instead of two."""
MARK_VARIABLE = "ROSBASE_CHILD_MARK"
"""Environment variable that marks the descendants of a manager; see `mark.py`."""


class Guardian:
    """Runs one command and ends all of its descendants."""

    def __init__(self, control: int, manager_pid: int) -> None:
        self._control = control
        # Taken out: a program that has children of its own decides about those.
        first_s = os.environ.pop(STOP_VARIABLE, "")
        self._usual = ((LADDER[0][0], float(first_s)), *LADDER[1:]) if first_s else LADDER
        self._ladder: list[tuple[int, float]] = []
        self._stage_ends: float | None = None
        self._is_killing = False
        self._command = 0
        # Signals arrive as bytes on a pipe, so that one poll waits for everything.
        self._signals, write_end = os.pipe()
        for fd in (write_end, self._signals):
            os.set_blocking(fd, False)
        signal.set_wakeup_fd(write_end)
        for number in (signal.SIGCHLD, *_stops()):
            signal.signal(number, lambda *_: None)
        # Whatever the manager blocks, this process and its command do not.
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        self._poll = select.poll()
        for fd in (control, self._signals, *_watch(manager_pid)):
            self._poll.register(fd, select.POLLIN)

    def run(self, argv: list[str], link: int) -> None:
        """Start the command, and return when none of its processes is left."""
        try:
            self._command = _start(argv, holds_signals=link >= 0)
        except OSError as error:
            self._say(f"failed {error.strerror}")
            return
        if link >= 0:
            # The other end is to notice when the node closes it.
            os.close(link)
        self._say(f"started {self._command}")
        while self._reap():
            self._climb()
            for fd, _ in self._poll.poll(self._patience_ms()):
                if fd == self._signals:
                    for number in set(os.read(fd, 512)) & _stops():
                        self._say(f"told {number}")
                        self._stop(self._usual)
                elif fd == self._control and _read(fd):
                    self._stop(self._usual)
                else:
                    # The manager is gone, and says nothing more.
                    self._poll.unregister(fd)
                    self._stop(SHORT_LADDER)

    def _stop(self, ladder: tuple[tuple[int, float], ...]) -> None:
        if self._stage_ends is None:
            self._ladder = list(ladder)
            self._stage_ends = 0.0
        elif ladder is SHORT_LADDER:
            # Those who are on their way out already get no more than the short time.
            self._ladder = list(ladder[len(ladder) - len(self._ladder) :])
            self._stage_ends = min(self._stage_ends, time.monotonic() + ladder[0][1])

    def _climb(self) -> None:
        if self._stage_ends is None:
            return
        family = _descendants()
        if self._is_killing:
            self._signal(SIGKILL, family)
        while time.monotonic() >= self._stage_ends:
            if not self._ladder:
                self._say(f"left {' '.join(map(str, family))}")
                os._exit(1)
            number, seconds = self._ladder.pop(0)
            self._is_killing = number == SIGKILL
            if self._is_killing:
                self._say("killed")
            # What a shell puts into the background ignores SIGINT: not worth waiting for. Looked at
            # before the signal, because a program may ignore further ones while it ends.
            is_worth_it = not family or any(_can_answer(pid, number) for pid in family)
            self._signal(number, family)
            if is_worth_it:
                self._stage_ends = time.monotonic() + seconds

    def _signal(self, number: int, family: list[int]) -> None:
        groups = {pid: _group_of(pid) for pid in family}
        # An empty group's number may be somebody else's by now.
        if not _IS_LINUX or self._command in groups.values():
            _ignoring_absence(os.killpg, self._command, number)
        for pid, group in groups.items():
            if group != self._command:
                _ignoring_absence(os.kill, pid, number)

    def _patience_ms(self) -> float | None:
        if self._stage_ends is None:
            return None
        left_s = max(0.0, self._stage_ends - time.monotonic())
        return 1000 * (min(left_s, _KILL_AGAIN_S) if self._is_killing else left_s) + 1

    def _reap(self) -> bool:
        """Report ended processes; return whether any is left."""
        while True:
            try:
                pid, status = os.waitpid(-1, os.WNOHANG)
            except ChildProcessError:
                return False
            if not pid:
                return True
            code = os.waitstatus_to_exitcode(status)
            self._say(f"ended {pid} {code}")
            if pid == self._command and code != 0:
                # What a command leaves behind that failed is of no use to anybody.
                self._stop(SHORT_LADDER)

    def _say(self, line: str) -> None:
        try:
            os.write(self._control, f"{line}\n".encode())
        except OSError:
            # Nobody listens any more.
            pass


def _start(argv: list[str], *, holds_signals: bool) -> int:
    guardian = os.getpid()
    # Closed by the exec: whoever is told the pid finds the command there, in its own session.
    started, starting = os.pipe()
    # Between the fork and the command one of these would find our handlers, and be lost.
    signal.pthread_sigmask(signal.SIG_BLOCK, _stops())
    pid = os.fork()
    if pid:
        os.close(starting)
        os.read(started, 1)
        os.close(started)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _stops())
        return pid
    try:
        os.setsid()
        _prctl(_PR_SET_PDEATHSIG, SIGKILL)
        if os.getppid() != guardian:
            # Killed before it could be said that this one dies with it.
            os._exit(128 + signal.SIGKILL)
        # Python ignores the last two, and that would be inherited.
        for number in (*_stops(), signal.SIGPIPE, signal.SIGXFSZ):
            signal.signal(number, signal.SIG_DFL)
        # A node takes the others when it is ready for them; see node_main.
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGHUP} if holds_signals else _stops())
        os.execv(argv[0], argv)
    except BaseException as error:
        os.write(2, f"{argv[0]}: {error}\n".encode())
    os._exit(127)


def _stops() -> set[int]:
    return {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}


def _label() -> None:
    """Put the label of the mark on this process and its descendants."""
    mark = os.environ.get(MARK_VARIABLE)
    if not mark or sys.platform != "linux":
        return
    label = int(mark.split()[-1].partition(".")[0], 16)
    try:
        hard = resource.getrlimit(_RLIMIT_LOCKS)[1]
        resource.setrlimit(_RLIMIT_LOCKS, (label, hard))
    except (OSError, ValueError):
        # Somebody has set a lower limit; the environment has to do.
        pass


def _prctl(option: int, value: int) -> None:
    if _IS_LINUX:
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def _watch(pid: int) -> list[int]:
    """Return a descriptor that becomes readable when that process ends, if the system has one.

    A closed socket shows the end too, unless a process that the manager forked still holds it.
    """
    try:
        watched = [os.pidfd_open(pid)]
    except (AttributeError, OSError):
        watched = []
    if os.getppid() != pid:
        # It is gone already, so nothing is to be started.
        sys.exit(0)
    return watched


def _read(fd: int) -> bytes:
    try:
        return os.read(fd, 512)
    except OSError:
        return b""


def _descendants() -> list[int]:
    """Return all descendants of this process that have not ended; none except on Linux."""
    parents = {pid: int(fields[1]) for pid, fields in _all_processes().items()}
    family = {os.getpid()}
    while grown := {pid for pid, parent in parents.items() if parent in family} - family:
        family |= grown
    return sorted(family - {os.getpid()})


def _all_processes() -> dict[int, list[bytes]]:
    found = {}
    for name in os.listdir("/proc") if _IS_LINUX else ():
        fields = stat_of(name) if name.isdigit() else None
        if fields is not None and not has_ended(fields):
            found[int(name)] = fields
    return found


def has_ended(fields: list[bytes]) -> bool:
    """Return whether a process has ended completely, from the result of `stat_of`."""
    # The process of a main thread that has ended before the others looks like a zombie.
    return fields[0] in (b"Z", b"X") and int(fields[17]) <= 1


def stat_of(pid: str | int) -> list[bytes] | None:
    """Return state, parent, group, session, ... of a process, from proc(5)."""
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            # The second field is the name, in brackets, and may hold anything.
            return file.read().rpartition(b")")[2].split()
    except OSError:
        return None


def _group_of(pid: int) -> int:
    fields = stat_of(pid)
    return int(fields[2]) if fields else 0


def _can_answer(pid: int, number: int) -> bool:
    fields = stat_of(pid)
    if number == SIGKILL:
        return True
    if fields is None or fields[0] in (b"T", b"t"):
        return False
    try:
        with open(f"/proc/{pid}/status", encoding="ascii", errors="replace") as file:
            masks = [line.split()[1] for line in file if line.startswith("SigIgn:")]
    except OSError:
        return False
    return not any(int(mask, 16) >> (number - 1) & 1 for mask in masks)


def _ignoring_absence(kill: Callable[[int, int], None], whom: int, number: int) -> None:
    try:
        kill(whom, number)
    except OSError:
        # It has ended meanwhile, or is not ours to signal.
        pass


def main() -> None:
    """Run and guard the command that the arguments name."""
    control, manager_pid, link = (int(number) for number in sys.argv[1:4])
    os.set_inheritable(control, False)
    _prctl(_PR_SET_CHILD_SUBREAPER, 1)
    # Should it be stopped when the manager dies, it goes on and clears away.
    _prctl(_PR_SET_PDEATHSIG, signal.SIGCONT)
    # Before there is a command, so that it has the label from its first moment.
    _label()
    Guardian(control, manager_pid).run(sys.argv[4:], link)


if __name__ == "__main__":
    main()
