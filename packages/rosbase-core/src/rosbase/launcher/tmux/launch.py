"""How a program starts in its pane."""

import os
import select
import signal
import subprocess

from attrs import frozen

from rosbase.launcher.description import Program
from rosbase.launcher.launches import ProgramLaunch
from rosbase.launcher.tmux.panes import Panes, give, read_guardian
from rosbase.processes.guardian import has_ended
from rosbase.processes.launch import GUARDIAN, Launch, Launched, Order
from rosbase.processes.mark import Mark, marked_environment, marks_in
from rosbase.processes.proc import everybody, read_of

__all__ = ["PaneLaunch"]


@frozen
class PaneLaunch(Launch):
    """Has a pane start the guardian of a program. Its output goes to the pane."""

    program: Program
    launch: ProgramLaunch
    panes: Panes
    is_read: bool
    """Whether the launcher reads the output too, because somebody waits for a line of it."""
    on_a_terminal = True

    def start(self, order: Order) -> Launched:
        """Start the program in its pane; open the pane if it was closed."""
        connection = self.panes.take(self.program)
        output = -1
        try:
            output = self.panes.tap(self.program.key) if self.is_read else _nothing()
            environment = marked_environment(order.mark, self.launch.environment)
            give(
                connection,
                {
                    "guardian": GUARDIAN,
                    "argv": self.launch.argv,
                    "environment": environment,
                    "cpus": self.launch.cpus,
                },
            )
            guardian = PaneGuardian(read_guardian(connection), order.mark)
        except BaseException:
            connection.close()
            if output >= 0:
                os.close(output)
            raise
        connection.settimeout(0.0)
        return Launched(guardian, connection, output, None)


class PaneGuardian:
    """A guardian that a pane has started, so that this process is not its parent."""

    def __init__(self, pid: int, mark: Mark) -> None:
        """Take hold of the process, if it has not ended already."""
        self.pid = pid
        self._mark = mark
        try:
            self._fd = os.pidfd_open(pid)
        except ProcessLookupError:
            # A short program is over before this; its last words wait in the connection.
            self._fd = -1

    def send_signal(self, sig: int) -> None:
        """Send a signal; do nothing if it has ended."""
        if self._fd >= 0:
            try:
                signal.pidfd_send_signal(self._fd, sig)
            except OSError:
                # It has just ended.
                pass

    def kill(self) -> None:
        """Send SIGKILL; do nothing if it has ended."""
        self.send_signal(signal.SIGKILL)

    def wait(self, timeout: float | None = None) -> int:
        """Wait for its end; return 0 unless it has left processes of the program behind."""
        if self._fd >= 0:
            if not select.select([self._fd], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired("guardian", timeout or 0.0)
            os.close(self._fd)
            self._fd = -1
        return int(any(self._is_left(pid, stat) for pid, stat in everybody().items()))

    def _is_left(self, pid: int, stat: list[bytes]) -> bool:
        return not has_ended(stat) and self._mark in marks_in(read_of(pid, "environ"))


def _nothing() -> int:
    """Return a descriptor that delivers nothing, and says so at once."""
    output, write_end = os.pipe()
    os.close(write_end)
    os.set_blocking(output, False)
    return output
