"""A guardian that a pane has started, seen from the launcher."""

import os
import signal
import subprocess
import sys

from rosbase.launcher.tmux.launch import PaneGuardian
from rosbase.processes.mark import Mark

MARK = Mark(1, (os.getpid(), 1), "test", "short")


def test_a_guardian_that_ended_before_the_launcher_looks_counts_as_ended() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    guardian = PaneGuardian(process.pid, MARK)
    guardian.send_signal(signal.SIGCONT)
    guardian.kill()
    assert guardian.wait(1.0) == 0
