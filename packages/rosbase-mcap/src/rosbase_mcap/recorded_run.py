"""The entries of a run on their way into its recording."""

from collections.abc import Iterable
from threading import get_ident
from typing import Any
from uuid import uuid4

from attrs import evolve

from rosbase.entries.conductor import Conductor
from rosbase.entries.sink import EndFacts, RunFacts
from rosbase.entries.trace import Trace
from rosbase.entries.turn import Turn
from rosbase_mcap.backlog import Item
from rosbase_mcap.channel_table import ORIGIN, ChannelTable
from rosbase_mcap.outputs import Digest
from rosbase_mcap.records import Attachment, Metadata
from rosbase_mcap.surroundings import surroundings
from rosbase_mcap.traces import Run, RunEnd, end_metadata, run_metadata, trace_attachment

__all__ = ["RecordedRun"]


class RecordedRun:
    """Takes the entries of a program; it implements `RecordingSink`.

    `begin` and `close` are called by the program, `number` by each thread that publishes, and all
    others by the thread that writes.
    """

    def __init__(self, topics: Iterable[str]) -> None:
        """Prepare.

        Args:
            topics: Names of the topics that are recorded; none stands for all.
        """
        self._topics = frozenset(f"/{topic.lstrip('/')}" for topic in topics)
        self._id = uuid4().hex
        self._conductor: Conductor | None = None
        # Nobody has it before there is a program.
        self._turn = Turn()
        self._trace = Trace()
        self._facts = RunFacts(0, 0)
        self._end: EndFacts | None = None
        self._digest = Digest()
        self._blocks = 0

    def begin(self, backend: Any, conductor: Conductor, trace: Trace, facts: RunFacts) -> None:
        """Take the entries of a program from now on."""
        self._conductor, self._turn, self._trace = conductor, conductor.turn, trace
        self._facts = evolve(facts, more={**surroundings(), **facts.more})

    def close(self, end: EndFacts) -> None:
        """Take what is known of the end of the run."""
        self._end = end

    @property
    def spoiled(self) -> str:
        """Why it cannot be replayed to its end; empty if it can. Known once it is closed."""
        return next(iter(self._end.spoiled), "") if self._end is not None else ""

    @property
    def is_followed(self) -> bool:
        """Whether there is a program whose entries are recorded."""
        return self._conductor is not None

    @property
    def number(self) -> int:
        """Number of the entry that the calling thread runs; -1 outside of the program."""
        return self._trace.number if self._turn.owner == get_ident() else -1

    def take(self) -> Attachment | None:
        """Return the entries since the last call; None if there are none."""
        block = self._trace.take()
        if not block.ints:
            return None
        self._blocks += 1
        return trace_attachment(block, self._blocks - 1, self._facts.start_date_ns)

    def count(self, items: Iterable[Item], table: ChannelTable) -> None:
        """Count messages that were written in the digest of the run."""
        for item in items:
            channel = table.channel(item[0])
            if ORIGIN not in channel.metadata:
                self._digest.add(item[1], channel.topic, item[4])

    def head(self, part: int) -> Metadata:
        """Return what is known of the run, for the start of the file of that number."""
        return run_metadata(Run(self._id, part, "start", self._topics, self._facts))

    def end(self) -> Metadata:
        """Return what is known of its end, for the end of the last file."""
        number = self._trace.number + 1
        facts = self._end or EndFacts(number, "", ("the recording has ended before the program",))
        return end_metadata(RunEnd(facts, self._digest.hexdigest))
