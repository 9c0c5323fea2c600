"""The launcher behind the panes of tmux: `python -m rosbase.launcher.tmux.background`.

It reads the programs from its standard input, opens the panes, says `ready` or the reason why not
on its standard output, and goes on without both. It ends when its programs have ended.
"""

import os
import pickle
import sys
from collections.abc import Collection, Mapping

from rosbase.clock import SystemClock
from rosbase.errors import RosbaseError
from rosbase.launcher.control import control_of
from rosbase.launcher.description import Description
from rosbase.launcher.launches import ProgramLaunch
from rosbase.launcher.ready_programs import ControlReadiness
from rosbase.launcher.run import Run
from rosbase.launcher.tmux.client import Tmux, session_size
from rosbase.launcher.tmux.launch import PaneLaunch
from rosbase.launcher.tmux.panes import Panes, opened
from rosbase.launcher.tmux.replace import end_session
from rosbase.launcher.tmux.show import PaneShow

__all__ = ["main"]


def main() -> None:
    """Run the programs that standard input describes."""
    description, enabled, launches, terminal = pickle.load(sys.stdin.buffer)
    clock = SystemClock()
    try:
        tmux = Tmux()
        sizes = {
            session.name: session_size(
                terminal, sum(program.key in enabled for program in session.programs)
            )
            for session in description.sessions
        }
        with opened(tmux, clock, sizes) as panes:
            for session in description.sessions:
                end_session(tmux, session.name)
            for program in description.programs:
                if program.key in enabled:
                    panes.open(program)
            run = _run(description, enabled, launches, panes, clock)
            with control_of(run, description):
                print("ready", flush=True)
                _leave_terminal()
                sys.exit(run.run())
    except (OSError, RosbaseError) as error:
        print(error, flush=True)
        sys.exit(1)


def _run(
    description: Description,
    enabled: Collection[str],
    launches: Mapping[str, ProgramLaunch],
    panes: Panes,
    clock: SystemClock,
) -> Run:
    programs = list(description.programs)
    sought = {
        key
        for program in programs
        for key, condition in program.after.items()
        if condition.kind == "log"
    }
    run = Run(
        programs,
        enabled,
        {
            program.key: PaneLaunch(program, launches[program.key], panes, program.key in sought)
            for program in programs
        },
        PaneShow(panes),
        ControlReadiness(),
        clock,
    )

    def stop_closed() -> None:
        for key in panes.closed():
            run.fleet.stop(key, clock.monotonic_ns())

    run.after_each_step(stop_closed)
    return run


def _leave_terminal() -> None:
    """Let go of the standard streams: whoever has started this process goes on."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for fd in range(3):
        os.dup2(nowhere, fd)
    os.close(nowhere)


if __name__ == "__main__":
    main()
