"""One replay in this process: from a file to what the program has published."""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from itertools import chain, takewhile
from typing import Any, TypeAlias

from attrs import evolve

from rosbase import Clock, ConfigurationError, make_logger
from rosbase.entries.conductor import Conductor
from rosbase.entries.current import conduct_next
from rosbase.entries.kinds import Kind
from rosbase.entries.replaying.pace import Pace
from rosbase.entries.replaying.player import Player
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.sink import RunFacts
from rosbase_mcap.bags import Bag, is_mcap, open_bag
from rosbase_mcap.outputs import Digest, Output
from rosbase_mcap.records import Schema
from rosbase_mcap.replaying.difference import Comparison, Difference, Flow, clock_text
from rosbase_mcap.replaying.late_pace import LatePace
from rosbase_mcap.replaying.listener import Listener
from rosbase_mcap.replaying.options import ReplayOptions, check_options
from rosbase_mcap.replaying.outcome import Outcome
from rosbase_mcap.replaying.recorded_outputs import RecordedOutputs
from rosbase_mcap.replaying.run_file import RunFile, open_run
from rosbase_mcap.replaying.topic_feed import TopicFeed

__all__ = ["Session"]

_Make: TypeAlias = Callable[[Clock], Conductor]


class Session:
    """Replays the next program of this process."""

    def __init__(
        self,
        options: ReplayOptions,
        hear: Callable[[Output], object] | None = None,
        *,
        may_have_topics_only: bool = False,
    ) -> None:
        """Read what is known of the recording.

        Args:
            options: What the user wants.
            hear: Takes each message of the program.
            may_have_topics_only: Replay the topics of a recording that has nothing else.

        Raises:
            McapError: The file cannot be read.
            ConfigurationError: It cannot be replayed in that way; the message says what can be
                done.
        """
        self.run: RunFile | None = open_run(options.path) if is_mcap(options.path) else None
        if may_have_topics_only and self.run is None and options.topics is None:
            options = evolve(options, topics=())
        check_options(options, self.run)
        self.schemas: dict[str, Schema] = {}
        """Schema of each topic of the program."""
        self._options, self._hear = options, hear
        self._digest, self._messages = Digest(), 0
        self._recorded: RecordedOutputs | None = None
        self._comparison: Comparison | None = None
        self._player: Player | None = None
        self._outcome: Outcome | None = None

    @contextmanager
    def conducting(self) -> Iterator[None]:
        """Replay the program that opens a backend in this block."""
        with ExitStack() as stack:
            if self._options.topics is None:
                assert self.run is not None
                make = self._of_all_inputs(self.run, stack)
            else:
                make = self._of_topics(stack.enter_context(open_bag(self._options.path)))
            conduct_next(make, is_replay=True)
            try:
                yield
            finally:
                conduct_next(None)
                self._end()

    @property
    def facts(self) -> Mapping[str, Any] | None:
        """Facts of the recorded program; None if only topics are replayed."""
        if self.run is None or self._options.topics is not None:
            return None
        return self.run.run.facts.more

    @property
    def recorded_topics(self) -> Collection[str]:
        """Full names of the topics of the recording that the replay has come to."""
        return self._recorded.schemas if self._recorded is not None else ()

    @property
    def start_ns(self) -> int:
        """Start of the run, in nanoseconds since 1970; 0 before it has begun."""
        return self._player.facts.start_date_ns if self._player is not None else 0

    @property
    def has_begun(self) -> bool:
        """Whether there was a program to replay."""
        return self._player is not None

    @property
    def is_early(self) -> bool:
        """Whether the replay is before the moment from which it is shown."""
        player, options = self._player, self._options
        if player is None or options.topics is not None:
            # A replay of topics starts there.
            return False
        return player.machine.t_ns < options.start_ns

    @property
    def outcome(self) -> Outcome:
        """The result. Only when the block of `conducting` has ended."""
        assert self._outcome is not None
        return self._outcome

    def _end(self) -> None:
        player = self._player
        t_ns = player.machine.t_ns if player is not None else 0
        difference = self._finish(self._comparison, player) if player is not None else None
        counts = self._digest.hexdigest, self._messages
        self._outcome = Outcome(difference, self._cut_short(), *counts, t_ns)

    def _of_all_inputs(self, run: RunFile, stack: ExitStack) -> _Make:
        start_ns = run.run.facts.start_date_ns
        # Generators that are not closed keep files open.
        outputs = self._recorded = stack.enter_context(closing(run.outputs()))
        whole = stack.enter_context(closing(read_entries(run.blocks())))
        entries = self._script(whole)
        first = next(entries, None)
        if first is None:
            killed = "its program was killed in the first second, or the disk was full"
            why = killed if run.end is None else "its first entries are damaged"
            raise ConfigurationError(f"{self._options.path} has no entry: {why}")
        script = chain([first], entries)
        self._comparison = Comparison(outputs, start_ns, context=self._context)
        listener = Listener(run.run.topics, self._declare, self._take)

        def make(clock: Clock) -> Player:
            self._player = Player(script, run.run.facts, sink=listener, pace=self._pace())
            return self._player

        return make

    def _of_topics(self, bag: Bag) -> _Make:
        options = self._options
        first_ns = self.run.run.facts.start_date_ns if self.run is not None else bag.start_ns
        start_ns = first_ns + options.start_ns
        end_ns = None if options.end_ns is None else first_ns + options.end_ns
        feed = TopicFeed(
            bag, options.topics or (), make_logger("replay"), start_ns=start_ns, end_ns=end_ns
        )
        listener = Listener((), self._declare, self._take, on_begin=feed.begin)
        facts = RunFacts(start_ns, 0)
        rate = options.rate

        def make(clock: Clock) -> Player:
            pace = Pace(rate) if rate is not None else None
            inputs = feed.inputs()
            self._player = Player((), facts, sink=listener, pace=pace, inputs=inputs)
            return self._player

        return make

    def _pace(self) -> Pace | None:
        rate = self._options.rate
        return None if rate is None else LatePace(rate, self._options.start_ns)

    def _script(self, entries: Iterator[Entry]) -> Iterator[Entry]:
        end_ns = self._options.end_ns
        if end_ns is None:
            return entries
        return takewhile(lambda entry: entry.t_ns <= end_ns, entries)

    def _declare(self, topic: str, schema: Schema) -> None:
        self.schemas[topic] = schema
        if self._comparison is not None:
            self._comparison.declare(topic, schema)

    def _take(self, number: int, topic: str, log_ns: int, data: bytes) -> None:
        player, comparison = self._player, self._comparison
        if player is None:
            return
        if player.is_free:
            if self._is_behind_the_end(player):
                return
            if comparison is not None:
                self._note_flow(comparison, player)
        self._messages += 1
        self._digest.add(number, topic, data)
        if comparison is not None:
            comparison.hear(number, topic, log_ns, data)
        if self._hear is not None:
            self._hear(Output(number, topic, log_ns, data))

    def _is_behind_the_end(self, player: Player) -> bool:
        """Return whether the script is over, and the program only ends."""
        is_over = player.is_free and player.difference is None
        return is_over and self._options.topics is None

    def _note_flow(self, comparison: Comparison, player: Player) -> None:
        flow = player.difference
        if flow is not None and not comparison.has_other_flow:
            lines = [f"before: {', '.join(flow.before)}"] if flow.before else []
            lines += [f"hint: {flow.hint}"] if flow.hint else []
            comparison.differ_in_flow(Flow(flow.what, flow.number, flow.t_ns, tuple(lines)))

    def _context(self) -> tuple[str, ...]:
        player = self._player
        if player is None:
            return ()
        now, recorded = player.reads
        lines = [f"before: {', '.join(player.recent())}"]
        if now > recorded:
            lines.append(
                f"hint: this entry read the clock {now} times, {recorded} in the recording"
            )
        return tuple(lines)

    def _finish(self, comparison: Comparison | None, player: Player) -> Difference | None:
        if comparison is None:
            return None
        self._note_flow(comparison, player)
        last = player.last
        end_ns = None if last.kind is Kind.END else player.facts.start_date_ns + last.t_ns
        found = comparison.finish(player.entry.number, end_ns)
        flow = player.difference
        if found is None or flow is None:
            return found
        lines = [*found.context]
        if found.flow is None:
            # A message was another before the program took another way.
            lines.append(f"then, at {clock_text(flow.t_ns)}, entry {flow.number}: {flow.what}")
        lines += [player.ended_early] if player.ended_early else []
        return evolve(found, context=tuple(lines))

    def _cut_short(self) -> str:
        player = self._player
        if player is None or self._options.topics is not None:
            return ""
        if player.spoiled:
            return player.spoiled
        if player.was_interrupted:
            return "it was stopped"
        if player.last.kind is Kind.END or self._options.end_ns is not None:
            return ""
        if player.difference is not None and player.inputs.next_ns is not None:
            # The changed program has ended, not the recording.
            return ""
        no_end = self.run.no_end if self.run is not None else ""
        return no_end or "the entries behind that are missing or damaged"
