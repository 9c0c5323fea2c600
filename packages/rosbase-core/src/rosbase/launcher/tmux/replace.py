"""End what runs in a tmux session before a new one takes its name."""

import os
import select
import signal

from rosbase.launcher.tmux.client import Tmux
from rosbase.processes.proc import read_of

__all__ = ["end_session"]

_PATIENCE_S = 120.0
_MODULE = b"rosbase.launcher.tmux.background"


def end_session(tmux: Tmux, session: str) -> None:
    """Stop the programs of an earlier run in their order, and end the session of that name.

    A program that still held a device would be in the way of its successor.
    """
    if not tmux.has_session(session):
        return
    noted = tmux.noted(session, "rosbase_launcher")
    if noted.isdecimal() and int(noted) != os.getpid():
        _end_launcher(int(noted))
    tmux.kill_session(session)


def _end_launcher(pid: int) -> None:
    try:
        process = os.pidfd_open(pid)
    except OSError:
        # It has ended by itself.
        return
    try:
        # The number may be another process's by now.
        if _MODULE in read_of(pid, "cmdline"):
            signal.pidfd_send_signal(process, signal.SIGTERM)
            select.select([process], [], [], _PATIENCE_S)
    except OSError:
        # It has just ended.
        pass
    finally:
        os.close(process)
