"""How a program of the launcher starts: its shell, its environment, its CPUs."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from attrs import field, frozen

from rosbase.launcher.description import Program, Session
from rosbase.launcher.machine import environment_for
from rosbase.launcher.shell import script, shell_path
from rosbase.parameters.given import GIVEN_VARIABLE, LAUNCHED_VARIABLE, GivenParameters
from rosbase.processes.guardian import MARK_VARIABLE, STOP_VARIABLE
from rosbase.processes.launch import Launch, Launched, Order, start_guarded
from rosbase.program.files import read_file
from rosbase.roles.connection import BACKEND_VARIABLE

__all__ = ["ProgramLaunch", "launch_of", "on_cpus"]


@frozen
class ProgramLaunch(Launch):
    """Starts the shell of a program under a guardian."""

    argv: tuple[str, ...]
    environment: Mapping[str, str]
    cpus: tuple[int, ...] = ()
    on_a_terminal: bool = field(default=False, kw_only=True)

    def start(self, order: Order) -> Launched:
        """Start it; everything that descends from it inherits the CPUs."""
        with on_cpus(self.cpus):
            return start_guarded(
                list(self.argv),
                order,
                on_a_terminal=self.on_a_terminal,
                environment=self.environment,
            )


def launch_of(session: Session, program: Program) -> ProgramLaunch:
    """Return the launch of a program.

    Raises:
        ConfigurationError: A parameter file cannot be read.
    """
    environment = environment_for(program, os.environ)
    values = [value for file in program.parameter_files for value in read_file(file)]
    if values or program.parameters:
        given = GivenParameters([*values, *program.parameters])
        environment[GIVEN_VARIABLE] = given.to_json()
    # Its own mark will be one more.
    environment[LAUNCHED_VARIABLE] = str(len(os.environ.get(MARK_VARIABLE, "").split()) + 1)
    if program.stop_timeout_s is not None:
        environment[STOP_VARIABLE] = str(program.stop_timeout_s)
    if program.backend:
        environment[BACKEND_VARIABLE] = program.backend
    return ProgramLaunch(
        (shell_path(environment), "-c", script(session, program), program.name),
        environment,
        program.cpus,
        on_a_terminal=program.on_a_terminal,
    )


@contextmanager
def on_cpus(cpus: tuple[int, ...]) -> Iterator[None]:
    """Run this thread, and what it starts meanwhile, on these CPUs; empty for no change.

    A child process inherits the CPUs of the thread that starts it. So the guardian is pinned too,
    and nothing of the program ever runs elsewhere.
    """
    if not cpus:
        yield
        return
    before: Any = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cpus)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)
