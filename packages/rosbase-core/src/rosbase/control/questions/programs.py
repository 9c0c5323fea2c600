"""Questions about programs as a whole: statistics, log, stop and restart."""

from __future__ import annotations

from rosbase.control.folder import sockets
from rosbase.control.gathering import ask_one, connect_to
from rosbase.control.questions.base import Questions, label
from rosbase.control.time_limit import TimeLimit
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import Any

    from rosbase.control.gathering import Ask
    from rosbase.control.joined_log import Repeats
    from rosbase.control.shapes import Launched, LogRecord, Process, Statistics
    from rosbase.control.watching import Watch

__all__ = ["ProgramQuestions"]

_RESTART_S = 30.0


class ProgramQuestions(Questions):
    """Questions about programs, and their end."""

    def statistics(self) -> list[Statistics]:
        """Return the times of the ticks of all programs that have a main loop."""
        found: list[Any] = []
        for pid, answer in self._gather("statistics"):
            found += [{**one, "pid": pid} for one in answer.get("programs", [answer])]
        return found

    def log(
        self, *, level: int = 0, last: int | None = None, follow: bool = False
    ) -> Iterator[LogRecord]:
        """Yield the records of the log that are in memory, oldest first, and then new ones.

        Args:
            level: The least level, a number of `logging`.
            last: How many records from the end; None for all that the programs have kept.
            follow: Whether to go on with new records, also of programs that start later. The
                iterator then ends only if one process was chosen, by its pid, and has ended.

        Raises:
            ControlError: The chosen program does not run, or a program could not send its log.
        """
        from rosbase.control.joined_log import Repeats, joined
        from rosbase.control.watching import Watch

        processes = self.processes()
        arguments: dict[str, Any] = {"level": level, "follow": follow}
        first = arguments if last is None else {**arguments, "last": last}
        watch = Watch([process["pid"] for process in processes], "log", first)
        repeats = Repeats(processes)
        if follow and not self._is_one_process():
            watch.look = self._newcomers(watch, repeats, arguments)
        try:
            yield from joined(watch, repeats, last)
            watch.check_ends()
        finally:
            watch.close()

    def _newcomers(
        self, watch: Watch, repeats: Repeats, arguments: dict[str, Any]
    ) -> Callable[[], None]:
        """Return a function that adds the logs of programs that have started meanwhile."""
        known = {stream.connection.pid for stream in watch.streams}

        def look() -> None:
            new = {pid for pid, _ in sockets()} - known
            if not new:
                return
            known.update(new)
            # With the others, because a program may be a child of another.
            processes = Questions(None, self._timeout_s, self._on_silent).processes()
            repeats.add(processes)
            for process in processes:
                if process["pid"] in new and self._is_meant(process):
                    try:
                        watch.add(process["pid"], "log", arguments)
                    except ControlError:
                        # It has ended already.
                        continue

        return look

    def processes_and_launched(self) -> tuple[list[Process], list[Launched]]:
        """Return what `processes` and `launched` do, of the same moment."""
        processes: list[Process] = []
        launched: list[Any] = []
        asks: list[Ask] = [("process", {}), ("launcher.list", {})]
        for pid, (process, started) in self._gather_all(asks):
            if not isinstance(process, ControlError):
                processes.append(process)
            if not isinstance(started, ControlError):
                launched += [{**one, "launcher": pid} for one in started["programs"]]
        return processes, launched

    def launched(self) -> list[Launched]:
        """Return the programs that `rosbase up` has started."""
        found: list[Any] = [
            {**one, "launcher": pid}
            for pid, answer in self._gather("launcher.list")
            for one in answer["programs"]
        ]
        return found

    def stop(self, name: str | int, *, timeout_s: float = 10.0) -> str:
        """End a program in order, as with Ctrl-C, and wait for its end; return what has ended.

        Args:
            name: A program, its pid, or the name of a program that `rosbase up` has started.
            timeout_s: How long to wait, in seconds.

        Raises:
            ControlError: No program has that name, or several have, or it has not ended in time.
        """
        if (one := self._launched_as(str(name))) is not None:
            ask_one(one["launcher"], "launcher.stop", {"name": one["name"]}, wait_s=_RESTART_S)
            return one["name"]
        try:
            process = self._named(str(name))
        except ControlError as error:
            raise _explained(error, str(name), self.launched()) from None
        connection = connect_to(process["pid"])
        try:
            connection.ask("stop", {}, wait_s=timeout_s)
            if not connection.wait_for_end(TimeLimit(timeout_s)):
                raise ControlError(f"{label(process)} still runs", "timeout")
        finally:
            connection.close()
        return label(process)

    def restart(self, name: str) -> str:
        """End and start a program of `rosbase up`; return its name.

        Raises:
            ControlError: No launcher has a program of that name.
        """
        one = self._launched_as(name)
        if one is None:
            from rosbase.control.names import unknown

            raise unknown("program of rosbase up", name, [o["name"] for o in self.launched()])
        ask_one(one["launcher"], "launcher.restart", {"name": one["name"]}, wait_s=_RESTART_S)
        return one["name"]

    def _launched_as(self, name: str) -> Launched | None:
        """Return the program of a launcher with that name or pid; None if there is none.

        Raises:
            ControlError: Several launchers have one.
        """
        found = self.launched()
        those = [o for o in found if name in (o["name"], str(o["pid"]))]
        # Within a session, programs have short names.
        those = those or [o for o in found if name == o["name"].rpartition("/")[2]]
        if len(those) > 1:
            raise _several(name, those)
        return those[0] if those else None


def _several(name: str, those: list[Launched]) -> ControlError:
    """Return the error for a name that several programs of launchers have."""
    if len({one["launcher"] for one in those}) == 1:
        keys = [one["name"] for one in those]
        return ControlError(f"{name} may be {' or '.join(keys)}", "ambiguous", keys)
    who = ", ".join(
        f"{one['name']} [{one['pid'] or one['state']}] of launcher [{one['launcher']}]"
        for one in those
    )
    pids = [str(one["pid"]) for one in those if one["pid"]]
    text = f"several launchers have a program {name}: {who}; choose one by its number"
    return ControlError(text, "ambiguous", pids)


def _explained(error: ControlError, name: str, launched: list[Launched]) -> ControlError:
    """Return an error, or a better one if a program of a launcher may have been meant."""
    from rosbase.control import names

    known = [one["name"] for one in launched]
    is_like_one = error.kind == "unknown" and not error.suggestions and names.similar(name, known)
    return names.unknown("program", name, known) if is_like_one else error
