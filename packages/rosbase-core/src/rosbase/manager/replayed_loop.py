"""The main loop of a program that is replayed: ticks come when the script says so."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from rosbase.entries.kinds import Kind, Numbered
from rosbase.entries.replaying.replayed_executor import ReplayedExecutor
from rosbase.entries.script import Entry
from rosbase.runtime.executor import Executor
from rosbase.runtime.rate import LoopStats, Rate

if TYPE_CHECKING:
    from rosbase.entries.replaying.player import Player

__all__ = ["run_replayed_loop"]

# In Python 3.11, to find a member takes 0.2 us.
_TICK, _TICK_END = Kind.TICK, Kind.TICK_END
_NS_PER_S = 1e9


def run_replayed_loop(
    executor: Executor,
    frequency_hz: float,
    tick: Callable[[], object],
    stopping: Callable[[], object],
    stats: LoopStats,
    look_after: Callable[[], object],
) -> None:
    """Run the recorded ticks, with what came between them, until `stopping`.

    Once the program does something else than it did when it was recorded, ticks are at absolute
    deadlines in virtual time.
    """
    assert isinstance(executor, ReplayedExecutor)
    player = executor.player
    loop = _Loop(player, tick, stats)
    player.check_period(Numbered.LOOP, 0, round(_NS_PER_S / frequency_hz))
    # The recorded loop asked at these places whether to stop.
    while not stopping():
        entry = executor.follow_to_loop()
        while entry is not None and entry.kind is _TICK:
            loop.run_tick(entry, len(executor.ready))
            entry = executor.follow_to_loop()
        if entry is None:
            _run_freely(executor, frequency_hz, loop, stopping, look_after)
            return
        if entry.kind is Kind.LOOK and player.take() is not None:
            look_after()


class _Loop:
    """The ticks of a replay, and their statistics."""

    def __init__(self, player: "Player", tick: Callable[[], object], stats: LoopStats) -> None:
        self._player, self._tick, self.stats = player, tick, stats
        self.started_ns: int | None = None
        """When the last tick began, on the monotonic clock; None before the first."""

    def run_tick(self, entry: Entry, waiting: int) -> None:
        """Run a recorded tick, if as many calls wait before it as did when it was recorded."""
        player = self._player
        if entry.ints[2] != waiting:
            player.differ(f"{waiting} instead of {entry.ints[2]} calls wait before a tick")
            return
        if player.take() is None:
            return
        self.begin(player.machine.monotonic_ns())
        try:
            self._tick()
        except BaseException as error:
            if player.next is not None and player.next.kind is _TICK_END:
                player.differ(f"the tick raised {type(error).__name__}: {error}")
            raise
        if not player.is_free:
            if player.next is None or player.next.kind is not _TICK_END:
                player.differ("the tick ends")
            elif (end := player.take()) is not None:
                self.stats.overruns = end.ints[1]
        self.stats.notes.append(player.machine.monotonic_ns())

    def begin(self, now_ns: int) -> None:
        """Note the start of a tick."""
        self.started_ns = now_ns
        # Noted before the tick, so that others can tell how long it has taken so far.
        self.stats.notes.append(now_ns)

    def run_free_tick(self, now_ns: Callable[[], int]) -> int:
        """Run a tick in virtual time, and return its end."""
        self.begin(now_ns())
        self._tick()
        end_ns = now_ns()
        self.stats.notes.append(end_ns)
        return end_ns


def _run_freely(
    executor: ReplayedExecutor,
    frequency_hz: float,
    loop: _Loop,
    stopping: Callable[[], object],
    look_after: Callable[[], object],
) -> None:
    stats, now_ns = loop.stats, executor.player.machine.monotonic_ns
    started_ns = loop.started_ns
    rate = Rate(frequency_hz, now_ns() if started_ns is None else started_ns)
    deadline_ns = rate.deadline_ns if started_ns is None else rate.advance(now_ns())
    skipped = stats.overruns
    stats.overruns += rate.skipped
    ticks_between = range(max(1, min(LoopStats.MANY_TICKS, int(frequency_hz / 2))))
    while not stopping():
        for _ in ticks_between:
            executor.spin_until(deadline_ns, stopping)
            if stopping():
                return
            deadline_ns = rate.advance(loop.run_free_tick(now_ns))
            stats.overruns = skipped + rate.skipped
        look_after()
