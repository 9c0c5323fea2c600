"""The script of a replay: the entries of a trace, one after the other."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

from attrs import define

from rosbase.entries.kinds import HAS_PAYLOAD, INTS, IS_NOTE, Kind
from rosbase.entries.payloads import Json, as_bytes, from_json
from rosbase.entries.trace import TraceBlock

__all__ = ["Creation", "Entry", "read_entries"]

T = TypeVar("T")

# Most entries have none. Shared, because a long recording has millions of entries.
_NO_NUMBERS: deque[int] = deque()
_NO_FACTS: deque[Json] = deque()
_KINDS: dict[int, Kind] = dict(zip(Kind, Kind, strict=True))
_SIZES = {kind: 1 + count for kind, count in INTS.items()}


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
    """A piece of work that ran as a whole, and what it asked of the world outside.

    A replay takes the readings and facts out of it. Nobody else may change it.
    """

    number: int
    """How many entries began before."""
    kind: Kind
    """What it is."""
    ints: Sequence[int]
    """The numbers of its kind, as `kinds` has them; the first is the time at which it began."""
    payload: bytes = b""
    """What came from outside."""
    reads_mono: deque[int] = _NO_NUMBERS
    """Values of the monotonic clock, in the order in which they were read."""
    reads_date: deque[int] = _NO_NUMBERS
    """Values of the date, since the date of the start."""
    reads_slept: deque[int] = _NO_NUMBERS
    """Values of `suspended_ns`."""
    reads_log: deque[int] = _NO_NUMBERS
    """Dates of log records, since the date of the start."""
    facts: deque[Json] = _NO_FACTS
    """Answers about things outside."""
    created: Sequence[Creation] = ()
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
        ints, place, end = block.ints, 0, len(block.ints)
        while place < end:
            code = ints[place]
            after = place + _SIZES[code]
            if code not in IS_NOTE:
                if entry is not None:
                    yield entry
                entry = Entry(expected, _KINDS[code], ints[place + 1 : after])
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
        entry.reads_mono = _with(entry.reads_mono, numbers[0])
    elif code == Kind.READ_DATE:
        entry.reads_date = _with(entry.reads_date, numbers[0])
    elif code == Kind.READ_SLEPT:
        entry.reads_slept = _with(entry.reads_slept, numbers[0])
    elif code == Kind.READ_LOG:
        entry.reads_log = _with(entry.reads_log, numbers[0])
    elif code == Kind.FACT:
        entry.facts = _with(entry.facts, from_json(payloads.popleft()))
    elif code == Kind.NEW:
        text = payloads.popleft().decode()
        entry.created = (*entry.created, Creation(numbers[0], numbers[1], text))
    else:
        entry.spoiled = payloads.popleft().decode()


def _with(values: deque[T], value: T) -> deque[T]:
    if not values:
        return deque((value,))
    values.append(value)
    return values
