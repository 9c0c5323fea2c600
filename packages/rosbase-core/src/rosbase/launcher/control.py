"""The launcher as other commands see it: `rosbase ps`, `stop NAME` and `restart NAME`."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import Any

from rosbase.control.programs import Program, is_control_on, offered
from rosbase.control.requests import Later, Request
from rosbase.errors import ControlError
from rosbase.launcher.description import Description
from rosbase.launcher.fleet import Entry
from rosbase.launcher.run import Run
from rosbase.logger import RosbaseLogger
from rosbase.parameters.checking import did_you_mean

__all__ = ["LauncherProgram", "control_of"]

# A stop takes four seconds at most, and a start in a new pane ten.
_TIMEOUT_NS = 20_000_000_000


class LauncherProgram(Program):
    """A run of the launcher. Its answers are given on the thread of the control socket."""

    kind = "launcher"

    def __init__(self, run: Run, name: str) -> None:
        """Show a run under a name."""
        self._run = run
        self._name = name
        # On the main thread: requests, each with the function that answers it once it is done.
        self._open: list[Callable[[], bool]] = []
        run.after_each_step(self._settle)
        self.phase = "running"

    @property
    def name(self) -> str:
        """Name of the first session."""
        return f"/{self._name}"

    @property
    def class_name(self) -> str:
        """Class of the launcher."""
        return "BaseLauncher"

    def facts(self) -> dict[str, Any]:
        """Return the programs as children."""
        entries = self._run.fleet.entries.values()
        return {
            "children": [
                {"name": e.key, "pid": self._run.pid_of(e.key), "running": e.is_alive}
                for e in entries
            ]
        }

    def request_stop(self) -> None:
        """Stop all programs, in the reverse order of their starts."""
        self.phase = "stopping"
        self._run.stop()

    def answers(self) -> Mapping[str, Callable[..., Any]]:
        """Return the answers to `launcher.list`, `launcher.stop` and `launcher.restart`."""
        return {
            "launcher.list": self._list,
            "launcher.stop": partial(self._command, self._stop),
            "launcher.restart": partial(self._command, self._restart),
        }

    def _list(self, session: object, request: Request) -> dict[str, Any]:
        run = self._run
        now_ns, date_ns = run.clock.monotonic_ns(), run.clock.now_ns()
        return {
            "programs": [
                {
                    "name": entry.key,
                    "pid": run.pid_of(entry.key),
                    "state": entry.state,
                    "detail": entry.detail,
                    "restarts": entry.total_restarts,
                    "since_ns": date_ns - (now_ns - entry.since_ns) if entry.since_ns else None,
                    "required": entry.program.is_required,
                    "exit_status": entry.status,
                }
                for entry in run.fleet.entries.values()
            ]
        }

    def _command(
        self, command: Callable[[Entry, Request], None], session: object, request: Request
    ) -> Later:
        name = request.text("name")
        entries = self._run.fleet.entries
        found = [entry for key, entry in entries.items() if name in (key, entry.program.name)]
        if not found:
            hint = did_you_mean(name, entries)
            raise ControlError(f"no program is called '{name}'{hint}", "unknown", list(entries))
        if len(found) > 1:
            keys = [entry.key for entry in found]
            raise ControlError(f"'{name}' may be {', '.join(keys)}", "ambiguous", keys)
        stop_ns = int((found[0].program.stop_timeout_s or 0.0) * 1e9)
        later = request.wait(timeout_ns=_TIMEOUT_NS + stop_ns)
        self._run.executor.call_soon(partial(command, found[0], request))
        return later

    # On the main thread.

    def _stop(self, entry: Entry, request: Request) -> None:
        self._run.fleet.stop(entry.key, self._run.clock.monotonic_ns())

        def settle() -> bool:
            if not entry.is_alive:
                request.answer({"name": entry.key, "state": entry.state})
            return not entry.is_alive

        self._open.append(settle)

    def _restart(self, entry: Entry, request: Request) -> None:
        fleet = self._run.fleet
        if fleet.is_stopping:
            request.fail(ControlError("the launcher is stopping", "refused"))
            return
        before = entry.total_restarts, entry.place
        fleet.restart(entry.key, self._run.clock.monotonic_ns())

        def settle() -> bool:
            is_new = (entry.total_restarts, entry.place) != before
            if is_new and entry.has_begun:
                request.answer({"name": entry.key, "state": entry.state})
                return True
            if fleet.is_stopping or (is_new and not entry.is_alive):
                request.fail(ControlError(f"{entry.key} has {entry.state}: {entry.detail}"))
                return True
            return False

        self._open.append(settle)

    def _settle(self) -> None:
        self._open = [settle for settle in self._open if not settle()]


@contextmanager
def control_of(run: Run, description: Description) -> Iterator[None]:
    """Let other commands see and drive a run, as long as the context lasts."""
    name = next((session.name for session in description.sessions), "launcher")
    program = LauncherProgram(run, name) if is_control_on() else None
    with offered(program, RosbaseLogger("launcher")):
        yield
