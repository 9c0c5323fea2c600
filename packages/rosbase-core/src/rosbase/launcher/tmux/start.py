"""Start the launcher behind tmux, and tell the user how to attach."""

import os
import pickle
import subprocess
import sys
from collections.abc import Collection, Mapping

from rosbase.errors import ConfigurationError
from rosbase.launcher.description import Description
from rosbase.launcher.launches import ProgramLaunch
from rosbase.launcher.tmux.client import Tmux

__all__ = ["start_in_tmux"]


def start_in_tmux(
    description: Description, enabled: Collection[str], launches: Mapping[str, ProgramLaunch]
) -> int:
    """Open a session with a pane for each program, and return the exit status.

    Raises:
        ConfigurationError: tmux is not installed, or refuses.
    """
    Tmux()
    process = subprocess.Popen(
        [sys.executable, "-m", "rosbase.launcher.tmux.background"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,
    )
    with process.stdin as orders, process.stdout as answers:  # type: ignore[union-attr]  # pipes
        pickle.dump((description, list(enabled), dict(launches), _terminal_size()), orders)
        orders.close()
        answer = answers.readline().decode(errors="replace").strip()
    if answer != "ready":
        process.wait()
        raise ConfigurationError(answer or "the launcher behind tmux has ended")
    # It outlives this process, on purpose.
    process.returncode = 0
    running = {program.session for program in description.programs if program.key in enabled}
    for session in description.sessions:
        if session.name in running:
            verb = "switch-client" if os.environ.get("TMUX") else "attach"
            print(f"{session.name}: tmux {verb} -t {session.name}")
    return 0


def _terminal_size() -> tuple[int, int] | None:
    """Return columns and lines of the user's terminal; None if there is none."""
    for stream in (sys.__stdout__, sys.__stdin__, sys.__stderr__):
        try:
            size = os.get_terminal_size(stream.fileno() if stream is not None else -1)
        except (OSError, ValueError):
            # It is a file, or closed.
            continue
        if size.columns and size.lines:
            return size.columns, size.lines
    return None
