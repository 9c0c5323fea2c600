"""Run the programs of a description until all have ended."""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from typing import Protocol

from rosbase.clock import Clock, SystemClock
from rosbase.launcher.crew import Crew, Show
from rosbase.launcher.description import Condition, Program
from rosbase.launcher.fleet import Entry, Fleet
from rosbase.launcher.readiness import Readiness, ReadinessWatch
from rosbase.launcher.stop_signals import stop_wishes
from rosbase.processes.launch import Launch
from rosbase.runtime.executor import Executor

__all__ = ["Run", "Screenful"]

_NS_PER_S = 1_000_000_000
_LONGEST_S = 1.0


class Screenful(Show, Protocol):
    """Shows a run; all but output is called on the main thread."""

    @property
    def period_s(self) -> float | None:
        """Seconds between updates, or None if `refresh` need not come regularly."""
        ...

    def refresh(self, entries: Sequence[Entry], pid_of: Callable[[str], int | None]) -> None:
        """Show the present states."""
        ...

    def end(self) -> None:
        """Finish what is shown."""
        ...


class Run:
    """One run of some programs."""

    def __init__(
        self,
        programs: Sequence[Program],
        enabled: Collection[str],
        launches: Mapping[str, Launch],
        show: Screenful,
        readiness: Readiness,
        clock: Clock | None = None,
    ) -> None:
        """Prepare a run; nothing starts yet.

        Args:
            programs: All programs.
            enabled: Keys of the ones that start.
            launches: How each of them starts, by its key.
            show: Shows what happens.
            readiness: Tells whether a program is ready.
            clock: The clock.
        """
        self.clock = clock or SystemClock()
        self.executor = Executor(self.clock)
        """Runs calls on the main thread."""
        self._show = show
        self._crew = Crew(launches, show, self.clock, self.executor.call_soon)
        self.fleet = Fleet(programs, enabled, self._crew)
        """The programs and their states, for the main thread only."""
        self._crew.fleet = self.fleet
        self._programs = programs
        self._watch = ReadinessWatch(readiness, self._is_ready)
        self._finds: list[Callable[[], object]] = []

    def pid_of(self, key: str) -> int | None:
        """Return the process id of a program's shell while it runs."""
        return self._crew.pid_of(key)

    def after_each_step(self, look: Callable[[], object]) -> None:
        """Have a function called on the main thread whenever something may have changed."""
        self._finds.append(look)

    def run(self) -> int:
        """Start everything, and return the exit status when all have ended."""
        with ExitStack() as ending:
            ending.enter_context(stop_wishes(self._take_wish, self.clock))
            ending.callback(self._show.end)
            self._crew.begin(self._programs)
            ending.callback(self._crew.close)
            ending.callback(self._watch.close)
            self._watch.start()
            self.fleet.begin(self.clock.monotonic_ns())
            while not self.fleet.is_over:
                self._step()
            self._refresh()
        return self.fleet.status

    def stop(self) -> None:
        """Stop everything in order. Call it from any thread or signal handler."""
        self.executor.call_soon(lambda: self.fleet.stop_all(self.clock.monotonic_ns()))

    def _take_wish(self, number: int) -> None:
        self.stop()
        if number > 1:
            self.executor.call_soon(self._crew.hurry)

    def _is_ready(self, key: str, condition: Condition) -> None:
        self.executor.call_soon(lambda: self.fleet.met(key, condition, self.clock.monotonic_ns()))

    def _step(self) -> None:
        dues = [_LONGEST_S if self._show.period_s is None else self._show.period_s]
        if (due_ns := self.fleet.due_ns) is not None:
            dues.append(max(0.0, (due_ns - self.clock.monotonic_ns()) / _NS_PER_S))
        if self.executor.spin_once(min(dues)):
            # Whatever else has happened meanwhile, before something is drawn.
            while self.executor.spin_once(0.0):
                pass
        self.fleet.tick(self.clock.monotonic_ns())
        self._watch.seek(self.fleet.wanted())
        for look in self._finds:
            look()
        self._refresh()

    def _refresh(self) -> None:
        self._show.refresh(list(self.fleet.entries.values()), self._crew.pid_of)
