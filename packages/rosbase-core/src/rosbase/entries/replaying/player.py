"""The conductor of a replay: it knows which entry is next, and whether the program follows."""

from collections import deque
from collections.abc import Callable, Iterable
from itertools import chain, islice
from typing import Any, TypeVar

from rosbase.entries.conductor import Play
from rosbase.entries.kinds import NUMBERED, SECTION_OPS, Kind, Numbered
from rosbase.entries.log_entrance import LogEntrance
from rosbase.entries.outcomes import error_from_json
from rosbase.entries.payloads import Json, Payload, from_json
from rosbase.entries.replaying.entered import Entered
from rosbase.entries.replaying.flow import (
    FlowDifference,
    entry_text,
    joined,
    period_text,
    time_text,
)
from rosbase.entries.replaying.inputs import INPUTS, Input, Inputs, inputs_of
from rosbase.entries.replaying.pace import Pace
from rosbase.entries.replaying.posted import PostedCalls
from rosbase.entries.replaying.registry import Registry
from rosbase.entries.replaying.replayed_clock import ReplayedClock
from rosbase.entries.replaying.replayed_executor import ReplayedExecutor
from rosbase.entries.replaying.virtual_clock import VirtualClock
from rosbase.entries.script import NO_NOTES, Entry
from rosbase.entries.sink import IN_PROCESS, EndFacts, RecordingSink, RunFacts
from rosbase.entries.trace import Trace
from rosbase.entries.turn import Turn

__all__ = ["Player"]

T = TypeVar("T")

_REMEMBERED = 5
# A signal that the program sends itself asks for a stop after what waits already.
_SOON = 50
_OUTSIDE = -1
# A program that goes on has them.
_REGULAR = frozenset({Kind.TICK, Kind.TIMER})
_IN_SECTIONS = INPUTS | {Kind.SECTION}
# In Python 3.11, to find a member takes longer than all else with an entry.
_TICK, _POSTED = Kind.TICK, Kind.POSTED
_NOTHING = Entry(-1, Kind.BEGIN, (0,))


class Player:
    """Replays a program: the thread that builds it runs the entries of a script.

    It is strict as long as the program follows the script. After the first difference it is free:
    what came from outside comes at its recorded time, and the rest follows from the program. At the
    end of the script it asks the program to stop.
    """

    is_replay = True

    # Every entry reads a dozen attributes. Python finds those of an object without slots slowly if
    # there are more than thirty.
    __slots__ = (
        "_created",
        "_entered",
        "_executor",
        "_handlers",
        "_is_ended",
        "_last",
        "_left",
        "_log",
        "_pace",
        "_periods",
        "_posted",
        "_recent",
        "_registry",
        "_script",
        "_sink",
        "_threads",
        "_ticks",
        "clock",
        "difference",
        "ended_early",
        "entry",
        "facts",
        "inputs",
        "is_free",
        "is_of_middleware",
        "machine",
        "next",
        "spoiled",
        "trace",
        "turn",
        "was_interrupted",
    )

    def __init__(
        self,
        script: Iterable[Entry],
        facts: RunFacts,
        *,
        sink: RecordingSink | None = None,
        pace: Pace | None = None,
        inputs: Iterable[Input] | None = None,
    ) -> None:
        """Begin the first entry.

        Args:
            script: The entries of a recording.
            facts: What is known of its run.
            sink: Receives what the program does in this run.
            pace: How fast to run; None for as fast as can be.
            inputs: If given, the replay is free from the start, and these come in instead of the
                script's. The program is asked to stop after the last.
        """
        self.turn = Turn()
        """The right to run the program, which one thread has for good."""
        self.turn.acquire()
        self.machine = VirtualClock(facts.start_date_ns, facts.start_monotonic_ns)
        self.clock: ReplayedClock = ReplayedClock(self, self.machine, self.turn)
        self.facts = facts
        """Facts of the recorded run."""
        self.is_of_middleware = not facts.more.get(IN_PROCESS, True)
        """Whether messages of the recorded program left its process."""
        self.difference: FlowDifference | None = None
        """The first difference of the flow; None if the program has followed the script."""
        self.ended_early = ""
        """That the program has ended before the recording, if another difference came first."""
        self.spoiled = ""
        """Why the script could not be followed to its end; empty if it could."""
        self.is_free = False
        """Whether the program no longer follows the script."""
        self.was_interrupted = False
        """Whether a signal has ended the replay."""
        self.inputs = Inputs(())
        """Inputs still to come in a free replay."""
        # Nobody notes in it: a sink reads the number of the entry that runs.
        self.trace = Trace()
        self.entry = _NOTHING
        """The entry that runs."""
        self.next: Entry | None = None
        """The entry that runs next; None at the end of the script, and in a free replay."""
        self._script = iter(script)
        # The one that was read last, if the replay is free.
        self._last: Entry | None = None
        self._left: Iterable[Entry] = ()
        self._sink, self._pace = sink, pace
        self._registry = Registry()
        self._handlers: dict[int, Play] = {}
        self._log = LogEntrance(self, self.clock.log_now_ns)
        self._posted = PostedCalls()
        self._entered = Entered()
        self._threads: dict[int, str] = {}
        self._recent: deque[Entry] = deque(maxlen=_REMEMBERED)
        self._created: deque[tuple[int, str]] = deque()
        # Recorded periods of objects that the program has not created yet.
        self._periods: dict[tuple[int, int], int] = {}
        self._ticks = 0
        self._executor: ReplayedExecutor | None = None
        self._is_ended = False
        if inputs is None:
            self.next = next(self._script, None)
            self.take()
        else:
            self._go_free(Inputs(self._with_stop(inputs)))

    # The protocol of a conductor.

    @property
    def is_inside(self) -> bool:
        """Whether the calling thread runs the program: the only one that does, from its start."""
        return self.turn.is_mine

    def make_executor(self) -> ReplayedExecutor:
        """Return the executor of the program; called once."""
        self._executor = ReplayedExecutor(self)
        return self._executor

    def begin(self, backend: Any) -> None:
        """Let the sink listen to the program."""
        self._log.begin()
        if self._sink is not None:
            self._sink.begin(backend, self, self.trace, self.facts)

    def end(self, error: BaseException | None) -> None:
        """End the replay, and let threads of the user go on. Idempotent."""
        if self._is_ended:
            return
        self._is_ended = True
        if not self.is_free and self.next is not None and self._goes_on():
            self._leave(self._early_end(self._rest([self.next]), goes_on=True))
        elif self.difference is not None and not self.was_interrupted:
            self.ended_early = self._early_end(self._left)
        # What other threads did until the last moment.
        while not self.is_free and self.next is not None:
            entry = self.take()
            if entry is not None and entry.kind in INPUTS:
                self.play(entry)
        self._log.end()
        self._posted.close()
        self._entered.close()
        if self._sink is not None:
            ended_by = f"{type(error).__name__}: {error}" if error is not None else ""
            self._sink.close(EndFacts(self.trace.number + 1, ended_by))

    def number(self, what: Numbered, text: str, play: Play) -> int:
        """Return the number of something that the program creates; -1 for a thread outside."""
        if not self.is_inside:
            return _OUTSIDE
        if not self.is_free:
            if not self._created or self._created[0] != (what, text):
                self._differ_in_creation(f"the program creates {_a(what)}: {text}")
            else:
                self._created.popleft()
        return self._registry.create(what, text, play)

    def forget(self, what: Numbered, number: int) -> None:
        """Note that the program has no use for an object any more."""
        self._registry.forget(what, number)

    def register(self, kind: Kind, play: Play) -> None:
        """Say what to do with entries of a kind whose objects have no number."""
        self._handlers[kind] = play

    def come_in(
        self, kind: Kind, numbers: tuple[int, ...], payload: Payload, run: Callable[[], object]
    ) -> None:
        """Run it at once if it comes from inside; else ignore it, for it comes from the file."""
        if self.is_inside:
            run()

    def enter(
        self, kind: Kind, numbers: tuple[int, ...], payload: Payload, run: Callable[[], T]
    ) -> T:
        """Run it if it comes from inside; else return its result when it comes from the file."""
        return run() if self.is_inside else self._entered.wait(kind)

    def fact(self, read: Callable[[], Json]) -> Json:
        """Return the recorded answer; what is known without it if there is none."""
        # A free program may ask something else, at another time.
        facts = self.entry.notes.facts
        if self.is_free or not self.is_inside or not facts:
            return read()
        return facts.popleft()

    def section(self, transport: int, op: str, call: Callable[[], Json]) -> Json:
        """Run what came in during the call, and return its result or raise its error."""
        call_numbers = (transport, SECTION_OPS.index(op))
        while self.is_inside and not self.is_free:
            coming = self.next
            if coming is None or coming.kind not in _IN_SECTIONS:
                self.differ(f"the program calls {op} of a transport")
                break
            if coming.kind == Kind.SECTION and tuple(coming.ints[1:3]) != call_numbers:
                self.differ(f"the program calls {op} of a transport")
                break
            entry = self.take()
            if entry is None:
                break
            if entry.kind != Kind.SECTION:
                self.play(entry)
            elif entry.ints[3]:
                return from_json(entry.payload)
            else:
                raise error_from_json(from_json(entry.payload))
        return None

    def aside(self, call: Callable[[], object]) -> None:
        """Do nothing: a replay has no backend that needs upkeep."""

    def spoil(self, reason: str) -> None:
        """Do nothing: the recording has noted it."""

    # For the executor and the main loop.

    def post(self, call: Callable[[], object]) -> None:
        """Keep a call of a thread of the user until the recording says when it came."""
        self._posted.post(call)

    def take(self) -> Entry | None:
        """Begin the next entry, and return it; None if the program has not done all of this one."""
        entry = self.next
        if entry is None:
            return None
        if self._created:
            what, text = self._created[0]
            self.differ(f"the program has not created {_a(what)}: {text}", self.entry)
            return None
        self.entry = entry
        self._recent.appendleft(entry)
        self.trace.number = entry.number
        if entry.kind is _TICK:
            self._ticks += 1
        # As `move_to`, which would be a call for each entry.
        machine, t_ns = self.machine, entry.ints[0]
        if t_ns > machine.t_ns:  # noqa: PLR1730 - `max` takes twice as long
            machine.t_ns = t_ns
        notes = entry.notes
        # Most entries have none, and most notes are readings, which the clock has taken.
        if notes is not NO_NOTES and (notes.created or notes.periods or notes.spoiled):
            self._note(entry)
        self.next = next(self._script, None)
        if self._pace is not None:
            self._pace.wait(entry.t_ns, self._is_over)
        return entry

    def check_period(self, what: Numbered, number: int, period_ns: int) -> None:
        """Compare how often something runs with the recording, which may not say it."""
        recorded_ns = self._periods.pop((what, number), period_ns)
        if recorded_ns != period_ns and not self.is_free:
            text = self._registry.recorded_text(what, number)
            self._leave(period_text(what, text, period_ns, recorded_ns))

    def play(self, entry: Entry) -> None:
        """Let an entry that came from outside come in."""
        kind = entry.kind
        if kind is _POSTED:
            self._play_posted(entry)
            return
        named = NUMBERED.get(kind)
        play = (
            self._handlers.get(kind)
            if named is None
            else self._registry.play_of(named, entry.ints[1])
        )
        if play is not None:
            if kind in self._entered.kinds:
                self._entered.carry_out(kind, lambda: play(entry))
            else:
                play(entry)
        elif named is not None and not self.is_free:
            self.differ(f"the program has no such {named.name.lower()}", entry)

    def differ(self, what: str, entry: Entry | None = None) -> None:
        """Note what the program does instead of an entry, once, and be free from now on.

        Args:
            what: What it does.
            entry: The entry; the next one if it is None.
        """
        if self.is_free:
            return
        recorded = entry or self.next
        if recorded is not None:
            self._leave(f"{what}; in the recording: {self._text(recorded)}")
        else:
            self._go_on_freely()

    def is_about_to_stop(self) -> bool:
        """Return whether the script stops the program soon. For signal handlers."""
        try:
            return not self.is_free and Kind.STOP in self._kinds_ahead()
        except ValueError:
            # The script is being read: the handler has interrupted that.
            return False

    def interrupt(self) -> None:
        """Stop following the script, because a signal ends the replay. For signal handlers."""
        self.was_interrupted = True
        if not self.is_free:
            self._go_free(Inputs(()))
        self.inputs.drop()

    def wait_for(self, t_ns: int) -> None:
        """Keep the pace in a free replay."""
        if self._pace is not None:
            self._pace.wait(t_ns, self._is_over)

    @property
    def last(self) -> Entry:
        """The entry of the script that was read last, which may be one that has not begun."""
        return self._last or self.next or self.entry

    @property
    def reads(self) -> tuple[int, int]:
        """How often the entry has read the clock so far, and how often it did when recorded."""
        return self.clock.reads

    @property
    def ticks(self) -> int:
        """Number of ticks that have begun."""
        return self._ticks

    def recent(self) -> tuple[str, ...]:
        """Return the entry that runs and the ones before it in a few words each, the last first."""
        return joined(self._recent, self._registry.recorded_text)

    # Own.

    def _is_over(self) -> bool:
        return self.was_interrupted

    def _note(self, entry: Entry) -> None:
        """Note what the entry creates, and whether the script ends with it."""
        self._note_created(entry)
        for what, number, period_ns in entry.notes.periods:
            self._periods[what, number] = period_ns
        if entry.notes.spoiled:
            self.spoiled = entry.notes.spoiled
            self._script = iter(())

    def _note_created(self, entry: Entry) -> None:
        for creation in entry.notes.created:
            if creation.what == Numbered.THREAD:
                self._threads[creation.number] = creation.text
                continue
            self._registry.note_recorded(creation)
            if not self.is_free:
                self._created.append((creation.what, creation.text))

    def _play_posted(self, entry: Entry) -> None:
        name = self._threads.get(entry.ints[1], "")
        call = self._posted.take(name)
        if call is not None and self._executor is not None:
            call()
        elif not self.is_free:
            self.differ(f"thread {name!r} has handed over no call", entry)

    def _play_free(self, entry: Entry) -> None:
        self._recent.appendleft(entry)
        self.entry, self.trace.number = entry, entry.number
        self._note_created(entry)
        if entry.kind in INPUTS:
            self.play(entry)

    def _rest(self, first: list[Entry]) -> Iterable[Entry]:
        yield from first
        for entry in self._script:
            self._last = entry
            yield entry
            if entry.notes.spoiled:
                self.spoiled = entry.notes.spoiled
                return

    def _with_stop(self, inputs: Iterable[Input]) -> Iterable[Input]:
        t_ns = 0
        for coming in inputs:
            t_ns = coming.t_ns
            yield coming
        yield Input(t_ns, self._stop)

    def _goes_on(self) -> bool:
        """Return whether the script has more than what others did, and its end."""
        ahead, coming = list[Entry](), self.next
        while coming is not None and coming.kind in INPUTS and not coming.notes.spoiled:
            coming = next(self._script, None)
            if coming is not None:
                ahead.append(coming)
        self._script = chain(ahead, self._script)
        return coming is not None and coming.kind not in INPUTS | {Kind.END}

    def _kinds_ahead(self) -> set[int]:
        """Return the kinds of the next entries."""
        ahead = list(islice(self._script, _SOON))
        self._script = chain(ahead, self._script)
        coming = [] if self.next is None else [self.next]
        return {entry.kind for entry in (*coming, *ahead)}

    def _early_end(self, left: Iterable[Entry], *, goes_on: bool = False) -> str:
        """Return that the program ends before the script; empty if it does not."""
        for entry in left:
            self._last = entry
            goes_on = goes_on or entry.kind in _REGULAR
        now, end = time_text(self.machine.t_ns), time_text(self.last.t_ns)
        return f"the program ends at {now}, and the recording goes on to {end}" if goes_on else ""

    def _leave(self, what: str) -> None:
        """Note the first difference, and no longer follow the script."""
        self.difference = self._flow_difference(what)
        self._go_on_freely()

    def _go_on_freely(self) -> None:
        self._left = self._rest([] if self.next is None else [self.next])
        self._go_free(Inputs(inputs_of(self._left, self._play_free, self._stop)))

    def _go_free(self, inputs: Inputs) -> None:
        self.is_free = True
        self.next = None
        self._created.clear()
        self._periods.clear()
        self.inputs = inputs
        self.clock.begin_free()
        if self._executor is not None:
            self._executor.begin_free()

    def _stop(self) -> None:
        stop = self._handlers.get(Kind.STOP)
        if stop is None:
            raise RuntimeError("the recording ends, and nothing of the program can be stopped")
        stop(_NOTHING)
        if self._executor is not None:
            # So that whoever spins looks whether to stop.
            self._executor.call_soon(_do_nothing)

    def _differ_in_creation(self, what: str) -> None:
        if self._created:
            other, text = self._created[0]
            what += f" instead of {_a(other)}: {text}"
        self.differ(what)

    def _flow_difference(self, what: str) -> FlowDifference:
        number, t_ns = self.entry.number, self.machine.t_ns
        now, recorded = self.reads
        hint = ""
        if now != recorded:
            hint = f"this entry read the clock {now} times, {recorded} in the recording"
        return FlowDifference(number, t_ns, self._ticks, what, self.recent(), hint)

    def _text(self, entry: Entry) -> str:
        return entry_text(entry, self._registry.recorded_text)


def _a(what: int) -> str:
    return f"a {Numbered(what).name.lower()}"


def _do_nothing() -> None:
    """Do nothing: called to wake the program."""
