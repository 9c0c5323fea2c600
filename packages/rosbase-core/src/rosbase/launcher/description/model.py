"""Sessions and programs as the launcher's file describes them."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Literal, TypeAlias

from attrs import field, frozen

from rosbase.parameters.given import GivenValue
from rosbase.processes.restart import RestartPolicy

__all__ = ["Condition", "ConditionKind", "Description", "Program", "Session"]

ConditionKind: TypeAlias = Literal["started", "lifecycle active", "handshake", "log", "exit 0"]


@frozen
class Condition:
    """The readiness of a program for which another one waits."""

    kind: ConditionKind = "started"
    pattern: str = ""
    """For `log`: the regular expression that a line of the output must match somewhere."""

    def __str__(self) -> str:
        """Return the condition as in the file."""
        return f"log: {self.pattern}" if self.kind == "log" else self.kind


@frozen
class Program:
    """A program of a session."""

    name: str
    session: str
    folder: Path
    """Absolute folder where it runs."""
    commands: tuple[str, ...]
    """Commands for one shell, one after another."""
    autostart: bool = True
    cpus: tuple[int, ...] = ()
    """CPUs for all of its processes; empty for all CPUs."""
    environment: Mapping[str, str] = field(factory=dict)
    restart: RestartPolicy = field(factory=RestartPolicy)
    after: Mapping[str, Condition] = field(factory=dict)
    """Conditions for its start, by the key of the program that meets them."""
    after_timeout_s: float | None = None
    """Seconds that it waits for them before it fails; None for no limit."""
    stop_timeout_s: float | None = None
    """Seconds between SIGINT and SIGTERM; None for two."""
    is_required: bool = False
    """Whether all others end when it ends for good."""
    parameters: tuple[GivenValue, ...] = ()
    parameter_files: tuple[Path, ...] = ()
    backend: str = ""
    on_a_terminal: bool = False
    """Whether its output goes to a pseudo-terminal instead of a pipe."""
    key: str = ""
    """Its name, or `session/name` if another session has a program of that name."""
    lines: Mapping[str, int] = field(factory=dict, eq=False, repr=False)
    """Lines of its keys in the file. The empty name has the line of the program."""


@frozen
class Session:
    """Programs with one workspace and one environment; with tmux, one session."""

    name: str
    workspace: Path
    programs: tuple[Program, ...]
    ros_setup: Path | None = None
    """Shell script that is sourced first."""
    conda_env: str = ""
    """Conda environment that is activated next; empty for none."""
    lines: Mapping[str, int] = field(factory=dict, eq=False, repr=False)


@frozen
class Description:
    """A whole file."""

    sessions: tuple[Session, ...]
    file: str = ""

    @property
    def programs(self) -> Iterator[Program]:
        """The programs of all sessions, in the order of the file."""
        for session in self.sessions:
            yield from session.programs
