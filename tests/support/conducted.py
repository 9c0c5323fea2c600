"""A small program on the backend `local`, which a test records and then replays."""

import threading
from collections.abc import Callable
from typing import Any

from attrs import frozen

from rosbase.contracts.backend import BackendOptions
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind
from rosbase.entries.recorder import Recorder
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import RunFacts
from rosbase.local import Bus, LocalBackend
from rosbase.testing import ManualClock

__all__ = ["ConductedProgram", "Recorded", "record", "replay"]

_NS_PER_S = 1_000_000_000


class ConductedProgram:
    """A backend, and a log of what the callbacks saw."""

    def __init__(self, conductor: Conductor) -> None:
        self.conductor = conductor
        self.bus = Bus()
        options = BackendOptions("robot", clock=conductor.clock)
        self.backend = LocalBackend(options, self.bus)
        self.seen: list[Any] = []
        self._stops: list[bool] = []
        conductor.register(Kind.STOP, lambda _: self._stops.append(True))
        self.backend.executor.begin(lambda: self._stops)

    def see(self, *values: Any) -> None:
        """Note what a callback sees."""
        self.seen.append(values)

    def spin(self, seconds: float = 0.1) -> None:
        """Handle callbacks for some time of the program's clock."""
        deadline_ns = self.backend.clock.monotonic_ns() + int(seconds * _NS_PER_S)
        self.backend.spin_until(deadline_ns, lambda: self._stops)

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
    spoiled: list[str]

    @property
    def kinds(self) -> list[Kind]:
        """The kinds of its entries."""
        return [entry.kind for entry in self.entries]


Run = Callable[[ConductedProgram], object]
_FACTS = RunFacts(ManualClock().now_ns(), 0)


def record(run: Run) -> Recorded:
    """Run a program, and record it."""
    recorder = Recorder(ManualClock())
    program = ConductedProgram(recorder)
    run(program)
    program.backend.close()
    recorder.end(None)
    entries = list(read_entries([recorder.trace.take()]))
    return Recorded(program.seen, entries, recorder.spoiled)


def replay(run: Run, recorded: Recorded) -> list[Any]:
    """Run a program as it was recorded; return what its callbacks saw.

    Raises:
        AssertionError: It does not follow the recording.
    """
    player = Player(recorded.entries, _FACTS)
    program = ConductedProgram(player)
    run(program)
    program.backend.close()
    player.end(None)
    assert player.difference is None, str(player.difference)
    return program.seen
