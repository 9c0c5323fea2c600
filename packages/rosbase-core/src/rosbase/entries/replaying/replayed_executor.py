"""The executor of a program that is replayed: it runs what the script says, and never sleeps."""

from collections.abc import Callable
from functools import partial
from threading import get_ident
from typing import TYPE_CHECKING

from rosbase.entries.kinds import Kind, Numbered, TimerOp
from rosbase.entries.payloads import Payload
from rosbase.entries.recorded_executor import name_of
from rosbase.entries.replaying.inputs import INPUTS
from rosbase.entries.script import Entry
from rosbase.errors import BackendError
from rosbase.runtime.executor import Executor, ExecutorTimer

if TYPE_CHECKING:
    from rosbase.entries.replaying.player import Player

__all__ = ["ReplayedExecutor", "ReplayedTimer"]

_NS_PER_S = 1_000_000_000
_LONGEST_S = 1e6
# In Python 3.11, to find a member takes longer than to run an entry.
_CALL, _TIMER, _URGENT, _RETURN = Kind.CALL, Kind.TIMER, Kind.URGENT, Kind.RETURN
_SPINS = INPUTS | {_CALL, _TIMER, _RETURN}
_WAITS = INPUTS | {_URGENT, _RETURN}
_OF_LOOP = frozenset({Kind.TICK, Kind.LOOK, _RETURN})


class ReplayedTimer(ExecutorTimer):
    """A timer with a number, which knows when it is due."""

    __slots__ = ("due_ns", "life", "number")

    def __init__(
        self, executor: "ReplayedExecutor", period_ns: int, callback: Callable[[], object]
    ) -> None:
        super().__init__(executor, period_ns, callback)
        self.number = -1
        """How many timers were created before; -1 for one of another thread."""
        self.due_ns = 0
        """Deadline of the next call, on the monotonic clock."""
        self.life = 0
        """How often it was started and stopped; a call queued before that does not count."""


class ReplayedExecutor(Executor):
    """Runs the calls and timers that the script names, while the program follows the script.

    Afterwards it is an executor in virtual time. What comes from outside comes when nothing else is
    left to do at that instant, so a tick and a timer of the same instant precede it.
    """

    __slots__ = ("_machine", "_timers_by_number", "_turn", "player")

    def __init__(self, player: "Player") -> None:
        super().__init__(player.clock)
        self.player, self._machine, self._turn = player, player.machine, player.turn
        self._monotonic_ns = player.machine.monotonic_ns
        self._wait = self._wait_freely
        self._timers_by_number: dict[int, ReplayedTimer] = {}

    def begin(self, stopping: Callable[[], object]) -> None:
        """Note that this thread runs the program."""
        self._turn.take_over()
        super().begin(stopping)

    def begin_free(self) -> None:
        """Run timers in virtual time from now on."""
        for timer in self._timers_by_number.values():
            if timer.serial is not None:
                super()._push(timer.due_ns, timer)

    # Calls from anywhere. Other threads' calls come when the script says so.

    def call_soon(self, function: Callable[[], object]) -> None:
        """Queue a call."""
        if self._turn.owner == get_ident():
            # Nobody sleeps who would have to be woken.
            self.ready.append(function)
        else:
            self.player.post(lambda: self.call_soon(function))

    def call_urgently(self, function: Callable[[], object]) -> None:
        """Queue a call that runs even during `wait`."""
        if self.player.is_inside:
            super().call_urgently(function)
        else:
            self.player.post(lambda: self.call_urgently(function))

    def call_from_outside(
        self,
        function: Callable[[], object],
        describe: Callable[[], tuple[int, tuple[int, ...], Payload]],
    ) -> None:
        """Queue a call from outside, if the script makes it; ignore it from others."""
        if self.player.is_inside:
            self.call_as_guest(function)

    def call_aside(self, function: Callable[[], object]) -> None:
        """Do nothing: a replay has no backend that needs upkeep."""

    def stop_soon(self, function: Callable[[], object]) -> None:
        """Call a function that requests a stop, for the script, the program or a signal."""
        if self.player.is_inside:
            function()

    def in_signal(self, function: Callable[[], object]) -> None:
        """Call a function for a signal: it ends the replay, of which the script knows nothing.

        If the program has sent it to itself, it was in the recording too, and comes from there.
        """
        if self.player.is_about_to_stop():
            return
        self.player.interrupt()
        function()

    # Timers.

    def create_timer(self, period_ns: int, callback: Callable[[], object]) -> ExecutorTimer:
        """Create a running timer, which gets a number."""
        if self._closed:
            raise BackendError("the backend is closed")
        timer = ReplayedTimer(self, period_ns, callback)
        timer.number = self.player.number(
            Numbered.TIMER, name_of(callback), lambda entry: self._operate(timer, entry)
        )
        if timer.number >= 0:
            self._timers_by_number[timer.number] = timer
            self.player.check_period(Numbered.TIMER, timer.number, period_ns)
        timer.reset()
        return timer

    def start_timer(self, timer: ExecutorTimer) -> None:
        """Restart a timer; a request of another thread comes from the script."""
        if self.player.is_inside:
            _end_life(timer)
            super().start_timer(timer)

    def cancel_timer(self, timer: ExecutorTimer, *, destroy: bool = False) -> None:
        """Stop a timer; a request of another thread comes from the script."""
        if not self.player.is_inside:
            return
        _end_life(timer)
        super().cancel_timer(timer, destroy=destroy)
        if destroy and isinstance(timer, ReplayedTimer):
            self._timers_by_number.pop(timer.number, None)
            self.player.forget(Numbered.TIMER, timer.number)

    # The thread that spins.

    def spin_once(self, timeout_s: float) -> bool:
        """Run what the recorded call ran; return what it returned."""
        while not self.player.is_free:
            entry = self._follow(_SPINS)
            if entry is not None and entry.kind is _RETURN:
                return bool(entry.ints[1])
        self._play_late()
        return super().spin_once(timeout_s)

    def spin_until(self, deadline_ns: int, stopping: Callable[[], object]) -> None:
        """Run what the recorded call ran."""
        while not self.player.is_free:
            entry = self._follow(_SPINS)
            if entry is not None and entry.kind is _RETURN:
                return
        self._play_late()
        super().spin_until(deadline_ns, stopping)

    def wait(
        self, done: Callable[[], object], deadline_ns: int, look_s: float = _LONGEST_S
    ) -> None:
        """Run the urgent calls that the recorded call ran."""
        outer_ns = self._waits_end_ns
        self._waits_end_ns = min(deadline_ns, outer_ns)
        self.depth += 1
        try:
            while not self.player.is_free:
                entry = self._follow(_WAITS)
                if entry is not None and entry.kind is _RETURN:
                    return
        finally:
            self._waits_end_ns = outer_ns
            self.depth -= 1
        super().wait(done, deadline_ns, look_s)

    def follow_to_loop(self) -> Entry | None:
        """Run what came between two ticks; return the next entry that is the main loop's own.

        Returns:
            A TICK or a LOOK, not begun yet, or a RETURN; None if the program no longer follows.
        """
        player, follow = self.player, self._follow
        while (coming := player.next) is None or coming.kind not in _OF_LOOP:
            follow(_SPINS)
            if player.is_free:
                return None
        return coming if coming.kind is not _RETURN else follow(_SPINS)

    def _follow(self, expected: frozenset[int]) -> Entry | None:
        """Run the next entry, and return it; None if the program no longer follows the script."""
        player = self.player
        coming = player.next
        if coming is None or (kind := coming.kind) not in expected:
            player.differ("the program waits for calls and messages")
            return None
        if (kind is _CALL and not self.ready) or (kind is _URGENT and not self._urgent):
            player.differ("no call is left")
            return None
        if player.take() is None:
            return None
        if kind is _CALL:
            self.ready.popleft()()
        elif kind is _TIMER and (timer := self._timers_by_number.get(coming.ints[1])) is not None:
            self._call_timer(timer, coming)
        elif kind is _URGENT:
            self._urgent.popleft()()
        elif kind is not _RETURN:
            player.play(coming)
        return coming

    def _operate(self, timer: ReplayedTimer, entry: Entry) -> None:
        """Do what another thread did with a timer."""
        if entry.ints[2] == TimerOp.DUE:
            # The machine's clock does not count for it.
            super().cancel_timer(timer)
            self.call_soon(partial(_call_if_alive, timer, timer.life))
        elif entry.ints[2] == TimerOp.RESET:
            self.start_timer(timer)
        else:
            self.cancel_timer(timer, destroy=entry.ints[2] == TimerOp.DESTROY)

    def _call_timer(self, timer: ReplayedTimer, entry: Entry) -> None:
        if timer.serial is None:
            self.player.differ("this timer does not run", entry)
            return
        late_ns = self._machine.start_ns + self._machine.t_ns - timer.due_ns
        periods = 1 if late_ns < timer.period_ns else 1 + late_ns // timer.period_ns
        # The script says when it is due.
        timer.due_ns += periods * timer.period_ns
        # Whose turn is next, should the program no longer follow.
        self._owes_a_call = True
        timer.callback()

    def _push(self, deadline_ns: int, timer: ExecutorTimer) -> None:
        if isinstance(timer, ReplayedTimer):
            timer.due_ns = deadline_ns
        if self.player.is_free:
            super()._push(deadline_ns, timer)
        else:
            # The script says when it is due.
            timer.serial = next(self._serials)

    def _wait_freely(self, timeout_s: float) -> bool:
        """Let in the next input if it is due; else move on to it, or to the end of the wait."""
        machine, inputs = self._machine, self.player.inputs
        next_ns = inputs.next_ns
        until_ns = machine.t_ns + round(timeout_s * _NS_PER_S)
        if next_ns is not None:
            if next_ns <= machine.t_ns:
                inputs.play_one()
                return True
            until_ns = min(until_ns, next_ns)
        self.player.wait_for(until_ns)
        machine.move_to(until_ns)
        return False

    def _play_late(self) -> None:
        """Let in what came while the program was busy: whatever spins first runs it."""
        machine, inputs = self._machine, self.player.inputs
        while (next_ns := inputs.next_ns) is not None and next_ns < machine.t_ns:
            inputs.play_one()


def _end_life(timer: ExecutorTimer) -> None:
    if isinstance(timer, ReplayedTimer):
        timer.life += 1


def _call_if_alive(timer: ReplayedTimer, life: int) -> None:
    if timer.life == life:
        timer.callback()
