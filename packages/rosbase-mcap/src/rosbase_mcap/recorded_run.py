"""The entries of a run on their way into its recording."""

from collections.abc import Iterable
from typing import Any
from uuid import uuid4

from attrs import evolve

from rosbase.entries.conductor import Conductor
from rosbase.entries.sink import EndFacts, RunFacts
from rosbase.entries.trace import Trace
from rosbase.entries.turn import Turn
from rosbase_mcap.records import Attachment, Metadata
from rosbase_mcap.surroundings import surroundings
from rosbase_mcap.traces import Run, RunEnd, end_metadata, run_metadata, trace_attachment

__all__ = ["RecordedRun"]


class RecordedRun:
    """Takes the entries of a program; it implements `RecordingSink`.

    `begin` and `close` are called by the program. `turn` and `trace` are read by each thread that
    publishes, and all else is used by the thread that writes.
    """

    def __init__(self, topics: Iterable[str]) -> None:
        """Prepare.

        Args:
            topics: Names of the topics that are recorded; none stands for all.
        """
        self._topics = frozenset(f"/{topic.lstrip('/')}" for topic in topics)
        self._id = uuid4().hex
        self._conductor: Conductor | None = None
        self.turn = Turn()
        """The right to run the program. Nobody has it before there is a program."""
        self.trace = Trace()
        """Where the program notes its entries; its number is that of the entry that runs."""
        self._facts = RunFacts(0, 0)
        self._end: EndFacts | None = None
        self._blocks = 0

    def begin(self, backend: Any, conductor: Conductor, trace: Trace, facts: RunFacts) -> None:
        """Take the entries of a program from now on."""
        self._conductor, self.turn, self.trace = conductor, conductor.turn, trace
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

    def take(self) -> Attachment | None:
        """Return the entries since the last call; None if there are none."""
        block = self.trace.take()
        if not block.ints:
            return None
        self._blocks += 1
        return trace_attachment(block, self._blocks - 1, self._facts.start_date_ns)

    def head(self, part: int) -> Metadata:
        """Return what is known of the run, for the start of the file of that number."""
        return run_metadata(Run(self._id, part, "start", self._topics, self._facts))

    def end(self) -> Metadata:
        """Return what is known of its end, for the end of the last file."""
        number = self.trace.number + 1
        facts = self._end or EndFacts(number, "", ("the recording has ended before the program",))
        return end_metadata(RunEnd(facts))
