"""Which processes are looked at. Pure."""

from collections.abc import Sequence

from rosbase import ControlError
from rosbase.control.buses import with_children
from rosbase.control.names import unknown
from rosbase.control.questions.base import label
from rosbase.control.shapes import Process

__all__ = ["chosen"]


def chosen(processes: Sequence[Process], name: str | None) -> list[Process]:
    """Return the process with a program of that name or with that pid, and its child processes.

    Args:
        processes: All that run.
        name: Name of a program, without the slash in front if you like, or a pid. None chooses
            all of them.

    Raises:
        ControlError: No program has that name, or several have.
    """
    if name is None:
        return list(processes)
    wanted = name.lstrip("/")
    those = [p for p in processes if wanted in (str(p["pid"]), *_names(p))]
    if not those:
        # A name says more than a pid, so a process has its pid only if it has no name.
        known = [one for p in processes for one in _names(p) or [str(p["pid"])]]
        raise unknown("program", name, known)
    if len(those) > 1:
        who = [label(p) for p in those]
        text = f"program {name} is in {len(who)} processes: {', '.join(who)}; name the pid"
        raise ControlError(f"{text}: rosbase view {those[0]['pid']}", "ambiguous", who)
    return with_children(those[0], processes)


def _names(process: Process) -> list[str]:
    return [program["name"].lstrip("/") for program in process["programs"]]
