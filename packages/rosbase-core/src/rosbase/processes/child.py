"""One child of a manager: whether it runs, and how it ended."""

import os
import signal
import socket
import subprocess

from rosbase.clock import Clock
from rosbase.processes.adoption import end_family
from rosbase.processes.launch import Launch, Launched
from rosbase.processes.mark import Mark
from rosbase.processes.observed import Observed
from rosbase.processes.output import OutputLines
from rosbase.processes.records import RecordLines
from rosbase.processes.restart import RestartPolicy, Restarts
from rosbase.processes.tracebacks import Tracebacks

__all__ = ["ChildProcess", "Life", "describe_end"]

_GUARDIAN_PATIENCE_S = 1.0
# By number: this module is imported where there is no SIGHUP.
_STOP_SIGNALS = (1, signal.SIGINT, signal.SIGTERM)
_STOP_CODES = {-number for number in _STOP_SIGNALS} | {128 + number for number in _STOP_SIGNALS}
_CANNOT_BE_STARTED = 126


class ChildProcess:
    """A child process by its name; its supervisor keeps the attributes up to date."""

    pid = Observed[int | None]()
    """Process id of the command or node; its shell may have left others behind."""
    is_alive = Observed[bool]()
    """Whether any of its processes runs."""
    exit_code = Observed[int | None]()
    """Last exit code: a status, or less than 0 for a signal of that number."""

    def __init__(
        self, name: str, launch: Launch, policy: RestartPolicy, *, is_required: bool = False
    ) -> None:
        self.name = name
        self.pid = None
        self.is_alive = False
        self.exit_code = None
        self.is_required = is_required
        """Whether the program ends when this child ends for good."""
        self.restarts = Restarts(policy)
        self.launch = launch

    def __repr__(self) -> str:
        """Show name and condition."""
        state = f"pid {self.pid}" if self.is_alive else f"exit code {self.exit_code}"
        return f"<child {self.name}: {state}>"


class Life:
    """One run of a child, from its start to the end of the last process that descends from it.

    Everything here happens on the supervisor's thread.
    """

    def __init__(
        self,
        child: ChildProcess,
        launched: Launched,
        mark: Mark,
        records: RecordLines,
        clock: Clock,
    ) -> None:
        self.child = child
        self.mark = mark
        self.started_ns = clock.monotonic_ns()
        self.control = launched.control
        self.output = launched.output
        self.ended_fd = _watch(launched.guardian.pid)
        """Descriptor that is readable once the guardian has ended; -1 where the system has none."""
        self.lines = OutputLines(for_a_screen=child.launch.on_a_terminal)
        self.records = records
        self.tracebacks = Tracebacks()
        self.fault = ""
        """Reason why it was stopped although nobody asked for the end of the program."""
        self.why_not_started = ""
        """Reason why nothing of it ever ran."""
        self.was_asked = False
        """Whether this process has asked it to stop while the others go on."""
        self.was_told = False
        """Whether another process has asked its guardian to stop it."""
        self.was_ending = False
        """Whether the end of the program had been requested when it ended."""
        self.was_killed = False
        """Whether it ended only with SIGKILL."""
        self.has_lost_guardian = False
        """Whether its guardian ended before it did."""
        self.left = ""
        """Process ids that not even SIGKILL ended."""
        self.is_reported = self.is_settled = False
        """Whether the log has its end, and the processes that ended with it."""
        self._clock = clock
        self._guardian = launched.guardian
        self._link = launched.link
        self._said = b""
        # Of the command, and of the first of its descendants that failed; there may be many.
        self._own_code = -signal.SIGKILL
        self._other_code = 0
        child.is_alive, child.pid, child.exit_code = True, None, None

    @property
    def has_failed(self) -> bool:
        """Whether it ended with a failure."""
        return self.child.exit_code != 0 or bool(self.fault)

    @property
    def may_be_a_stop(self) -> bool:
        """Whether it may have been stopped from outside, perhaps together with the manager."""
        code = self.child.exit_code
        # Who is asked to stop may do so in order.
        return not self.fault and (self.was_told or code in _STOP_CODES or code == 0)

    def ask_to_stop(self) -> None:
        """Ask the guardian to stop it."""
        try:
            self.control.send(b"s")
        except OSError:
            # It has ended; its last words are on their way.
            pass
        self.wake()

    def hurry(self) -> None:
        """Have the guardian end it in less than a second, as if this process were gone."""
        try:
            self.control.shutdown(socket.SHUT_WR)
        except OSError:
            # It has ended.
            pass
        self.wake()

    def wake(self) -> None:
        """Continue the guardian if someone has stopped it with SIGSTOP."""
        self._guardian.send_signal(signal.SIGCONT)

    def hear(self) -> bool:
        """Read the guardian's messages; return False after the last one."""
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
        """Wait for the guardian's end, and end every process that it left behind."""
        self.control.close()
        if self.ended_fd >= 0:
            os.close(self.ended_fd)
        try:
            self.has_lost_guardian = self._guardian.wait(_GUARDIAN_PATIENCE_S) != 0
        except subprocess.TimeoutExpired:
            self.has_lost_guardian = True
        if self.has_lost_guardian:
            self.kill()
        failed = -signal.SIGKILL if self.has_lost_guardian else 0
        self.child.exit_code = self._code() or failed

    def close(self) -> None:
        """Release the rest; after this nothing more comes from it."""
        os.close(self.output)
        if self._link is not None:
            self._link.close()
        self.child.is_alive = False

    def kill(self) -> None:
        """Kill the guardian and all of its descendants."""
        self._guardian.kill()
        self._guardian.wait()
        left = end_family(self.mark, self._clock)
        self.left = ", ".join(map(str, left))

    def _take(self, what: str, values: list[str]) -> None:
        if what == "started":
            self.child.pid = int(values[0])
        elif what == "failed":
            self.why_not_started = " ".join(values)
            self._own_code = _CANNOT_BE_STARTED
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
        elif what == "told":
            self.was_told = True
        elif what == "killed":
            self.was_killed = True
        elif what == "left":
            self.left = ", ".join(values)

    def _code(self) -> int:
        """Return the exit code of the command or of a failed background process."""
        return self._own_code or self._other_code


def _watch(pid: int) -> int:
    try:
        return os.pidfd_open(pid)
    except (AttributeError, OSError):
        # Its end of the control socket tells, unless somebody whom we forked holds on to it.
        return -1


def describe_end(code: int) -> str:
    """Describe an exit code as a sentence about the child."""
    if code >= 0:
        return f"ended with status {code}"
    try:
        return f"was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"was ended by signal {-code}"
