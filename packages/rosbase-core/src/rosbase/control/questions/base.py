"""Ask the programs of this user, or one of them."""

from __future__ import annotations

from rosbase.control.gathering import gather, name_on_stderr
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence
    from typing import Any

    from rosbase.control.gathering import Ask, Replies
    from rosbase.control.shapes import Process
    from rosbase.control.time_limit import TimeLimit

__all__ = ["Questions", "label"]

_MOST_DIGITS = 18


def label(process: Process) -> str:
    """Return how a process is named in a message: `robot [4711]`."""
    return f"{process['name'].lstrip('/') or 'process'} [{process['pid']}]"


class Questions:
    """Questions to all programs, or to one.

    Nothing is kept between two questions, so any thread may ask, and each answer is of the
    programs that run at that time. Only a program that has not answered is left out for five
    seconds, so that it does not delay each question.
    """

    def __init__(
        self,
        program: str | int | None = None,
        timeout_s: float = 1.0,
        on_silent: Callable[[str], object] | None = name_on_stderr,
    ) -> None:
        """Ask all programs, or the one with that name or pid.

        Args:
            program: The name of a program, or the pid of its process; None asks all.
            timeout_s: How long all programs together may take.
            on_silent: Called for each program that does not answer, with a line that names it.
        """
        self._program = program
        self._timeout_s = timeout_s
        self._on_silent = on_silent
        self._silent_until: dict[str, TimeLimit] = {}

    def require(self) -> None:
        """Check that the chosen program runs.

        Raises:
            ControlError: It does not.
        """
        self._gather_all([("process", {})])

    def processes(self) -> list[Process]:
        """Return the running processes, by pid."""
        return [process for _, process in self._gather("process")]

    def _gather(self, ask: str, **arguments: Any) -> list[tuple[int, Any]]:
        """Return the answers to one question, with the pid of each; refusals are left out."""
        return [
            (pid, answers[0])
            for pid, answers in self._gather_all([(ask, arguments)])
            if not isinstance(answers[0], ControlError)
        ]

    def _gather_all(self, asks: Sequence[Ask]) -> list[tuple[int, list[Any]]]:
        """Return the answers to several questions.

        Raises:
            ControlError: The chosen program does not run.
        """
        pids = self._chosen()
        found = gather(asks, self._timeout_s, pids, self._on_silent, self._silent_until)
        if pids is not None and not found:
            raise self._not_running()
        return [(replies.pid, replies.answers) for replies in found]

    def _chosen(self) -> list[int] | None:
        """Return the pid of the chosen program; None for all.

        Raises:
            ControlError: No program has that name, or several have.
        """
        if self._program is None:
            return None
        if self._is_one_process():
            return [int(self._program)]
        return [self._named(str(self._program))["pid"]]

    def _is_one_process(self) -> bool:
        """Return whether a process was chosen by its pid."""
        return self._program is not None and _is_pid(str(self._program))

    def _is_meant(self, process: Process) -> bool:
        """Return whether a process is the chosen one, or has the chosen program."""
        if self._program is None or self._is_one_process():
            return self._program is None or process["pid"] == int(self._program)
        return str(self._program).lstrip("/") in _names_of(process)

    def _named(self, name: str) -> Process:
        """Return the process with a program of that name, or that pid."""
        found = [reply.answers[0] for reply in self._all_replies()]
        processes: list[Process] = [p for p in found if not isinstance(p, ControlError)]
        if _is_pid(name):
            those = [p for p in processes if p["pid"] == int(name)]
        else:
            wanted = name.lstrip("/")
            those = [p for p in processes if wanted in _names_of(p)]
        if len(those) == 1:
            return those[0]
        # Only after a mistake.
        from rosbase.control import names

        if not those:
            known = [n for p in processes for n in (*_names_of(p), str(p["pid"]))]
            raise self._explained(names.unknown("program", name, known), known)
        raise ControlError(
            f"{len(those)} programs are named {name}: {', '.join(map(label, those))}; "
            "choose one by the number of its process",
            "ambiguous",
            [str(p["pid"]) for p in those],
        )

    def _all_replies(self) -> list[Replies]:
        """Return what every process says of itself, whichever program was chosen."""
        asks: list[Ask] = [("process", {})]
        return gather(asks, self._timeout_s, None, self._on_silent, self._silent_until)

    def _not_running(self) -> ControlError:
        text = f"no program {self._program} runs, or it has no control socket"
        return ControlError(text, "unknown")

    def _labels(self) -> dict[int, str]:
        return {process["pid"]: label(process) for process in self.processes()}

    def _one(self, kind: str, name: str, owners: Mapping[str, list[int]]) -> tuple[str, int]:
        """Return the full name and the pid of the only process that has it.

        Raises:
            ControlError: None has it, or several have.
        """
        full = name if name in owners or name.startswith("/") else f"/{name}"
        pids = set(owners.get(full, ()))
        if len(pids) == 1:
            return full, pids.pop()
        from rosbase.control import names

        try:
            return names.one_of(kind, name, owners, self._labels() if pids else {})
        except ControlError as error:
            raise self._explained(error, owners) from None

    def _explained(self, error: ControlError, known: Collection[str]) -> ControlError:
        """Return the error for a name, with the reason if there are no names at all."""
        if error.kind != "unknown" or known:
            return error
        head = str(error).partition("; ")[0]
        if any(not limit.is_over for limit in self._silent_until.values()):
            return ControlError(f"{head} among the programs that answer", "unknown")
        if not self._all_replies():
            return ControlError(f"{head}; no program runs", "unknown")
        return error


def _is_pid(name: str) -> bool:
    """Return whether a name is the number of a process."""
    # Python reads none of thousands of digits.
    return name.isdecimal() and len(name) <= _MOST_DIGITS


def _names_of(process: Process) -> list[str]:
    """Return the names of the programs in a process, without the slash in front."""
    return list(dict.fromkeys(program["name"].lstrip("/") for program in process["programs"]))
