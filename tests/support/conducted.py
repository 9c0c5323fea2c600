"""A small program on the backend `local`, which a test records and then replays."""

import threading
from collections.abc import Callable
from typing import Any

from attrs import frozen

from rosbase.clock import Clock
from rosbase.contracts.backend import BackendOptions
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import RunFacts
from rosbase.local import Bus, LocalBackend
from rosbase.testing import ManualClock

__all__ = ["ConductedProgram", "Recorded", "on_thread", "record", "replay"]

_NS_PER_S = 1_000_000_000
_LONG_S = 30.0


class ConductedProgram:
    """A backend, and a log of what the callbacks saw."""

    def __init__(self, conductor: Conductor) -> None:
        self.conductor = conductor
        self.bus = Bus()
        options = BackendOptions("robot", clock=conductor.clock)
        self.backend = LocalBackend(options, self.bus)
        self.seen: list[Any] = []
        self._stops: list[bool] = []
        conductor.register(Kind.STOP, lambda _: self._stop())
        conductor.begin(self.backend)
        self.backend.executor.begin(lambda: self._stops)

    def see(self, *values: Any) -> None:
        """Note what a callback sees."""
        self.seen.append(values)

    def spin(self, seconds: float = 0.1) -> None:
        """Handle callbacks for some time of the program's clock."""
        deadline_ns = self.backend.clock.monotonic_ns() + int(seconds * _NS_PER_S)
        self.backend.spin_until(deadline_ns, lambda: self._stops)

    def spin_while(self, function: Callable[[], object]) -> None:
        """Handle callbacks while another thread calls a function; a replay has what comes of it."""
        failures: list[BaseException] = []

        def call() -> None:
            try:
                function()
            except BaseException as error:
                failures.append(error)
            self.backend.executor.stop_soon(self._stop)

        thread = threading.Thread(target=call, name="outside")
        if not self.conductor.is_replay:
            thread.start()
        self.spin(_LONG_S)
        self._stops.clear()
        # Also what the function leaves behind.
        self.spin()
        if not self.conductor.is_replay:
            thread.join()
        if failures:
            raise failures[0]

    def _stop(self) -> None:
        self._stops.append(True)
        self.backend.call_soon(list)

    def outside(self, function: Callable[[], object]) -> None:
        """Call a function on another thread, and wait for its end within the entry that runs."""
        thread = threading.Thread(target=function, name="outside")
        thread.start()
        thread.join()

    def outside_once(self, function: Callable[[], object]) -> None:
        """Call it as `outside`, but not in a replay: the recording has what comes of it."""
        if not self.conductor.is_replay:
            self.outside(function)


@frozen
class Recorded:
    """What is left of a recorded run."""

    seen: list[Any]
    entries: list[Entry]
    facts: RunFacts
    spoiled: list[str]

    @property
    def kinds(self) -> list[Kind]:
        """The kinds of its entries."""
        return [entry.kind for entry in self.entries]


Run = Callable[[ConductedProgram], object]


def record(run: Run, clock: Clock | None = None) -> Recorded:
    """Run a program, and record it; in virtual time, unless there is another clock."""
    recorder = Recorder(clock or ManualClock())
    program = ConductedProgram(recorder)
    run(program)
    program.backend.close()
    recorder.end(None)
    entries = list(read_entries([recorder.trace.take()]))
    facts = RunFacts(recorder.clock.start_date_ns, recorder.clock.start_ns)
    return Recorded(program.seen, entries, facts, recorder.spoiled)


def replay(run: Run, recorded: Recorded) -> list[Any]:
    """Run a program as it was recorded; return what its callbacks saw.

    Raises:
        AssertionError: It does not follow the recording.
    """
    player = Player(recorded.entries, recorded.facts)
    program = ConductedProgram(player)
    run(program)
    program.backend.close()
    player.end(None)
    assert player.difference is None, str(player.difference)
    return program.seen


def on_thread(function: Callable[[], object]) -> None:
    """Call a function on another thread, and wait for its end."""
    thread = threading.Thread(target=function, name="outside")
    thread.start()
    thread.join()
