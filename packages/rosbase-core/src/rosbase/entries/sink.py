"""The interface between a recorder and the file, or the memory, that it records into."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from attrs import field, frozen

from rosbase.entries.trace import Trace

if TYPE_CHECKING:
    from rosbase.entries.conductor import Conductor

__all__ = ["IN_PROCESS", "EndFacts", "RecordingSink", "RunFacts"]

IN_PROCESS = "delivers_in_process"
"""Fact: whether messages reached subscriptions of the program without leaving its process."""


@frozen
class RunFacts:
    """Facts of a run that are known at its start."""

    start_date_ns: int
    """The date, in nanoseconds since the Unix epoch, from which dates in the trace count."""
    start_monotonic_ns: int
    """The monotonic time from which times in the trace count."""
    more: Mapping[str, Any] = field(factory=dict)
    """Other facts by name: argv, given parameters, hash seed, versions. All can be JSON."""


@frozen
class EndFacts:
    """Facts of a run that are known at its end."""

    entries: int
    """Number of its entries."""
    ended_by: str = ""
    """The error that has ended it, in one line; empty for a stop."""
    spoiled: Sequence[str] = ()
    """Why it cannot be replayed to its end; empty if it can."""


class RecordingSink(Protocol):
    """Writes a run: taps, listeners and the trace.

    A message or log record is an output of the entry `trace.number` if
    `conductor.is_inside`; otherwise it comes from outside.
    """

    def begin(self, backend: Any, conductor: "Conductor", trace: Trace, facts: RunFacts) -> None:
        """Set taps and listeners, and start a thread that calls `trace.take` until `close`.

        Called once, on the thread that builds the program, before its first component.

        Args:
            backend: The connection of the program, `rosbase.Backend`.
            conductor: Knows whether the calling thread runs the program.
            trace: Where entries are noted.
            facts: What is known of the run.
        """
        ...

    def close(self, end: EndFacts) -> None:
        """Write the rest. Called once, on the thread of the program, after its clean-up."""
        ...
