"""Start and stop the programs under guardians, and tell the fleet what becomes of them."""

import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Protocol

from rosbase.clock import Clock
from rosbase.launcher.description import Condition, Program
from rosbase.launcher.fleet import Entry, Fleet
from rosbase.logger import RosbaseLogger
from rosbase.processes.child import ChildProcess, Life
from rosbase.processes.journal import Journal
from rosbase.processes.judge import Judge
from rosbase.processes.launch import Launch
from rosbase.processes.supervisor import Supervisor

__all__ = ["Crew", "Show"]


_MOST_SEARCHED = 2_000
"""Characters of a line in which a pattern is looked for."""


class Show(Protocol):
    """Shows what happens. Output and ends come on the thread of the supervisor."""

    def output(self, key: str, text: str, *, is_error: bool) -> None:
        """Show a line of a program's output."""
        ...

    def say(self, key: str, level: int, text: str) -> None:
        """Show a line about a program."""
        ...

    def changed(self, entry: Entry) -> None:
        """Show a change of state."""
        ...


class _Lines(Journal):
    """Shows output and ends, and looks for the lines that somebody waits for."""

    def __init__(self, show: Show, on_line: Callable[[str, str], object]) -> None:
        super().__init__(RosbaseLogger("launcher"))
        self._show = show
        self._on_line = on_line

    def write(self, level: int, name: str, text: str, *, is_chosen: bool = False) -> None:
        self._show.say(name, level, text)

    def write_output(self, life: Life, lines: Iterable[str]) -> None:
        name = life.child.name
        for line in lines:
            is_error = life.tracebacks.is_part(line) and not life.was_asked
            self._show.output(name, line, is_error=is_error)
            self._on_line(name, line)


class _Ends(Judge):
    """Hands each end to the fleet, which decides."""

    def __init__(self, journal: Journal, on_end: Callable[..., object]) -> None:
        super().__init__(journal)
        self._on_end = on_end
        self._told: set[str] = set()

    def ended(self, life: Life, now_ns: int) -> None:
        if life.was_told:
            self._told.add(life.child.name)
        super().ended(life, now_ns)

    def hesitates(self, life: Life) -> bool:
        is_success = life.child.exit_code == 0 and not life.was_told
        return (
            super().hesitates(life)
            and not life.was_asked
            and (life.child.is_required or not is_success)
        )

    def decide(
        self, child: ChildProcess, now_ns: int, *, failed: bool, ran_s: float, status: int
    ) -> None:
        was_told = child.name in self._told
        self._told.discard(child.name)
        self._on_end(child.name, status, ran_s, was_told=was_told)


class Crew:
    """Carries out the decisions of a fleet. Every event reaches the fleet on the main thread."""

    def __init__(
        self,
        launches: Mapping[str, Launch],
        show: Show,
        clock: Clock,
        call_soon: Callable[[Callable[[], object]], object],
    ) -> None:
        """Prepare the programs.

        Args:
            launches: How each program starts, by its key.
            show: Shows what happens.
            clock: The clock.
            call_soon: Runs a function on the main thread.
        """
        self.fleet: Fleet | None = None
        """The fleet that hears of the events; to be set before the first start."""
        self._launches = launches
        self._show = show
        self._clock = clock
        self._call_soon = call_soon
        self._children: dict[str, ChildProcess] = {}
        self._patterns: dict[str, dict[Condition, re.Pattern[str]]] = {}
        # Of the present run of each program: the patterns that no line has matched yet.
        self._sought: dict[str, dict[Condition, re.Pattern[str]]] = {}
        judge = _Ends(_Lines(show, self._seek), self._ended)
        self._supervisor = Supervisor([], judge.journal.logger, clock, judge=judge)

    def begin(self, programs: Iterable[Program]) -> None:
        """Start the thread that serves the programs.

        Raises:
            OSError: The machine has no more threads.
        """
        for program in programs:
            for other, condition in program.after.items():
                if condition.kind == "log":
                    pattern = re.compile(condition.pattern)
                    self._patterns.setdefault(other, {})[condition] = pattern
        self._supervisor.start()

    def close(self) -> None:
        """Stop every program that still runs, and the thread."""
        self._supervisor.stop()

    def hurry(self) -> None:
        """End all programs in less than a second."""
        self._supervisor.call(self._supervisor.hurry)

    def pid_of(self, key: str) -> int | None:
        """Return the process id of a program's shell while it runs."""
        child = self._children.get(key)
        return child.pid if child is not None and child.is_alive else None

    # What the fleet asks for, on the main thread.

    def start(self, program: Program) -> None:
        """Start a program."""
        self._supervisor.call(partial(self._start, program))

    def stop(self, program: Program) -> None:
        """Ask a program to stop."""
        self._supervisor.call(partial(self._stop, program))

    def changed(self, entry: Entry) -> None:
        """Show a change of state."""
        self._show.changed(entry)

    def say(self, key: str, level: int, text: str) -> None:
        """Show a line about a program."""
        self._show.say(key, level, text)

    # On the supervisor's thread.

    def _start(self, program: Program) -> None:
        key = program.key
        child = ChildProcess(
            key, self._launches[key], program.restart, is_required=program.is_required
        )
        self._children[key] = child
        self._sought[key] = dict(self._patterns.get(key, {}))
        try:
            self._supervisor.begin(child)
        except Exception as error:
            # Of the system, mostly; whatever it is, this program has not started.
            child.is_alive = False
            self._tell(partial(self._fleet().could_not_start, key, str(error)))
        else:
            self._tell(partial(self._fleet().started, key))

    def _stop(self, program: Program) -> None:
        if program.key in self._children:
            self._supervisor.end(self._children[program.key])

    def _ended(self, key: str, status: int, ran_s: float, *, was_told: bool) -> None:
        fleet = self._fleet()
        self._tell(lambda now_ns: fleet.ended(key, status, ran_s, now_ns, was_told=was_told))

    def _seek(self, key: str, line: str) -> None:
        sought = self._sought.get(key)
        if not sought:
            return
        # A search must not take long: the output of all programs waits for it.
        begin = line[:_MOST_SEARCHED]
        for condition in [one for one, pattern in sought.items() if pattern.search(begin)]:
            del sought[condition]
            self._tell(partial(self._fleet().met, key, condition))

    def _tell(self, event: Callable[[int], object]) -> None:
        self._call_soon(lambda: event(self._clock.monotonic_ns()))

    def _fleet(self) -> Fleet:
        if self.fleet is None:
            raise RuntimeError("nobody commands this crew")
        return self.fleet
