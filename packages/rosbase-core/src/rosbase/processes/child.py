"""One child of a manager: whether it lives, and how it ended."""

import os
import signal
import subprocess

from rosbase.processes.guardian import members_of_session
from rosbase.processes.launch import Launch, Launched
from rosbase.processes.output import OutputLines
from rosbase.processes.restart import RestartPolicy, Restarts

__all__ = ["ChildProcess", "Life", "describe_end"]

_GUARDIAN_PATIENCE_S = 1.0


class ChildProcess:
    """A child by its name; what is known of it is kept up to date by its supervisor."""

    def __init__(self, name: str, launch: Launch, policy: RestartPolicy) -> None:
        self.name = name
        self.pid: int | None = None
        """The process of the command or node; its shell may have left others behind."""
        self.is_alive = False
        """Whether anything of it runs."""
        self.exit_code: int | None = None
        """How it ended the last time: a status, or less than 0 for a signal of that number."""
        self.restarts = Restarts(policy)
        self.launch = launch

    def __repr__(self) -> str:
        """Name and condition."""
        state = f"pid {self.pid}" if self.is_alive else f"exit code {self.exit_code}"
        return f"<child {self.name}: {state}>"


class Life:
    """One life of a child, from its start to the end of the last process that descends from it.

    Everything here happens on the supervisor's thread.
    """

    def __init__(self, child: ChildProcess, launched: Launched, now_ns: int) -> None:
        self.child = child
        self.started_ns = now_ns
        self.control = launched.control
        self.output = launched.output
        self.ended_fd = _watch(launched.guardian.pid)
        """Readable once the guardian has ended; -1 where the system has no such thing."""
        self.lines = OutputLines()
        self.was_killed = False
        """Whether it did not end before SIGKILL."""
        self.left = ""
        """Process numbers that not even SIGKILL ended."""
        self.is_reported = False
        """Whether its end has been written into the log."""
        self._guardian = launched.guardian
        self._link = launched.link
        self._said = b""
        # Of the command, and of the first of its descendants that failed; there may be many.
        self._own_code = -signal.SIGKILL
        self._other_code = 0
        child.is_alive, child.pid, child.exit_code = True, None, None

    def ask_to_stop(self) -> None:
        """Has the guardian stop it."""
        try:
            self.control.send(b"s")
        except OSError:
            # It has ended; its last words are on their way.
            pass

    def hear(self) -> bool:
        """Takes in what the guardian says; false when it has said everything."""
        try:
            data = self.control.recv(4096)
        except BlockingIOError:
            return True
        except OSError:
            data = b""
        *lines, self._said = (self._said + data).split(b"\n")
        for line in lines:
            what, *values = line.decode().split()
            self._take(what, values)
        return bool(data)

    def finish(self) -> None:
        """Sees the guardian off, and gives everything back."""
        self.control.close()
        for fd in (self.output, self.ended_fd):
            if fd >= 0:
                os.close(fd)
        try:
            has_failed = self._guardian.wait(_GUARDIAN_PATIENCE_S) != 0
        except subprocess.TimeoutExpired:
            has_failed = True
        if has_failed:
            self.kill()
        if self._link is not None:
            self._link.close()
        self.child.exit_code = self._code() or (-signal.SIGKILL if has_failed else 0)
        self.child.is_alive = False

    def kill(self) -> None:
        """Ends the guardian and the session of the command by force."""
        self._guardian.kill()
        self._guardian.wait()
        for pid in members_of_session(self.child.pid) if self.child.pid else ():
            try:
                os.kill(pid, signal.SIGKILL)
            except OSError:
                # It has ended meanwhile.
                pass

    def _take(self, what: str, values: list[str]) -> None:
        if what == "started":
            self.child.pid = int(values[0])
        elif what == "ended":
            pid, code = int(values[0]), int(values[1])
            if pid != self.child.pid:
                # Who writes into a pipe that nobody reads any more has done its work.
                has_failed = code not in (0, -signal.SIGPIPE)
                self._other_code = self._other_code or (code if has_failed else 0)
                return
            self._own_code = code
            if code:
                # The guardian clears away what it leaves behind; that takes a moment.
                self.child.exit_code = code
        elif what == "killed":
            self.was_killed = True
        elif what == "left":
            self.left = ", ".join(values)

    def _code(self) -> int:
        """The command's; or that of what it left in the background, if that failed."""
        return self._own_code or self._other_code


def _watch(pid: int) -> int:
    try:
        return os.pidfd_open(pid)
    except (AttributeError, OSError):
        # Its end of the control socket tells, unless somebody whom we forked holds on to it.
        return -1


def describe_end(code: int) -> str:
    """An exit code as a sentence about the child."""
    if code >= 0:
        return f"ended with status {code}"
    try:
        return f"was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"was ended by signal {-code}"
