"""The script of a replay: the entries of a trace, one after the other."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence

from attrs import Factory, define

from rosbase.entries.kinds import HAS_PAYLOAD, INTS, IS_NOTE, Kind
from rosbase.entries.payloads import Json, as_bytes, from_json
from rosbase.entries.trace import TraceBlock

__all__ = ["Creation", "Entry", "read_entries"]


@define
class Creation:
    """Something with a number that the program created."""

    what: int
    """What it is, as in `Numbered`."""
    number: int
    """Its number: how many of its kind were created before."""
    text: str
    """Its topic, service, callback or plugin."""


@define
class Entry:
    """A piece of work that ran as a whole, and what it asked of the world outside."""

    number: int
    """How many entries began before."""
    kind: Kind
    """What it is."""
    ints: Sequence[int]
    """The numbers of its kind, as `kinds` has them; the first is the time at which it began."""
    payload: bytes = b""
    """What came from outside."""
    reads_mono: deque[int] = Factory(deque)
    """Values of the monotonic clock, in the order in which they were read."""
    reads_date: deque[int] = Factory(deque)
    """Values of the date, since the date of the start."""
    reads_slept: deque[int] = Factory(deque)
    """Values of `suspended_ns`."""
    reads_log: deque[int] = Factory(deque)
    """Dates of log records, since the date of the start."""
    facts: deque[Json] = Factory(deque)
    """Answers about things outside."""
    created: list[Creation] = Factory(list)
    """What the program created."""
    spoiled: str = ""
    """Why the run cannot be replayed from here on; empty if it can."""

    @property
    def t_ns(self) -> int:
        """The time at which it began, in nanoseconds since the start of the run."""
        return self.ints[0]


def read_entries(blocks: Iterable[TraceBlock]) -> Iterator[Entry]:
    """Return the entries of a trace, each with all its notes.

    It ends at a gap between two blocks. The last entry of a trace that was cut off is left out,
    because notes of it may be missing.
    """
    entry: Entry | None = None
    expected = 0
    payloads: deque[bytes] = deque()
    for block in blocks:
        if block.first_entry != expected:
            return
        payloads.extend(map(as_bytes, block.payloads))
        ints = block.ints
        place, end = 0, len(ints)
        while place < end:
            code = ints[place]
            after = place + 1 + INTS[code]
            if code not in IS_NOTE:
                if entry is not None:
                    yield entry
                entry = Entry(expected, Kind(code), ints[place + 1 : after])
                expected += 1
                if code in HAS_PAYLOAD:
                    entry.payload = payloads.popleft()
            elif entry is not None:
                _add_note(entry, code, ints[place + 1 : after], payloads)
            place = after
    if entry is not None and entry.kind is Kind.END:
        yield entry


def _add_note(entry: Entry, code: int, numbers: Sequence[int], payloads: deque[bytes]) -> None:
    if code == Kind.READ_MONO:
        entry.reads_mono.append(numbers[0])
    elif code == Kind.READ_DATE:
        entry.reads_date.append(numbers[0])
    elif code == Kind.READ_SLEPT:
        entry.reads_slept.append(numbers[0])
    elif code == Kind.READ_LOG:
        entry.reads_log.append(numbers[0])
    elif code == Kind.FACT:
        entry.facts.append(from_json(payloads.popleft()))
    elif code == Kind.NEW:
        entry.created.append(Creation(numbers[0], numbers[1], payloads.popleft().decode()))
    else:
        entry.spoiled = payloads.popleft().decode()
