"""The script of a replay: the entries of a trace, one after the other."""

from collections import deque
from collections.abc import Generator, Iterable, Sequence
from typing import Any, TypeVar

from attrs import define

from rosbase.entries.kinds import HAS_PAYLOAD, INTS, IS_NOTE, Kind
from rosbase.entries.payloads import Json, as_bytes, from_json
from rosbase.entries.trace import TraceBlock

__all__ = ["NO_NOTES", "Creation", "Entry", "Notes", "read_entries"]

# By the number of a kind: how many numbers it takes with its own, which entry it begins (notes
# begin none), and whether it has a payload. One look at a table takes less time than three.
_STEPS = {
    int(kind): (1 + size, None if kind in IS_NOTE else Kind(kind), kind in HAS_PAYLOAD)
    for kind, size in INTS.items()
}
_READ_MONO, _READ_DATE, _READ_SLEPT = map(int, (Kind.READ_MONO, Kind.READ_DATE, Kind.READ_SLEPT))
_READ_LOG, _FACT, _NEW = map(int, (Kind.READ_LOG, Kind.FACT, Kind.NEW))
_PERIOD = int(Kind.PERIOD)
# Nobody can add to it. A deque takes a kilobyte, so only what there is has one.
_NOTHING: deque[Any] = deque(maxlen=0)

T = TypeVar("T")


@define
class Creation:
    """Something with a number that the program created."""

    what: int
    """Class of the object, as in `Numbered`."""
    number: int
    """Its number: how many of its kind were created before."""
    text: str
    """Its topic, service, callback or plugin."""


class Notes:
    """Readings, facts and creations that belong to an entry."""

    # What an entry does not have, its class has: so to make one costs next to nothing.
    mono: deque[int] = _NOTHING
    """Values of the monotonic clock, in the order in which they were read."""
    date: deque[int] = _NOTHING
    """Values of the date, since the date of the start."""
    slept: deque[int] = _NOTHING
    """Values of `suspended_ns`."""
    log: deque[int] = _NOTHING
    """Dates of log records, since the date of the start."""
    facts: deque[Json] = _NOTHING
    """Answers about things outside."""
    created: deque[Creation] = _NOTHING
    """Objects that the program created."""
    periods: deque[Sequence[int]] = _NOTHING
    """Class, number and period of objects that run again and again, in nanoseconds."""
    spoiled: str = ""
    """Why the run cannot be replayed from here on; empty if it can."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Notes) and vars(self) == vars(other)

    __hash__ = None  # type: ignore[assignment]  # as attrs does it

    def __repr__(self) -> str:
        return f"Notes({', '.join(f'{name}={value!r}' for name, value in vars(self).items())})"


NO_NOTES = Notes()
"""The notes of the entries without any, which are most. Nobody adds to them."""


@define
class Entry:
    """A piece of work that ran as a whole."""

    number: int
    """How many entries began before."""
    kind: Kind
    """Kind of the entry."""
    ints: Sequence[int]
    """The numbers of its kind, as `kinds` has them; the first is the time at which it began."""
    payload: bytes = b""
    """Content that came from outside."""
    notes: Notes = NO_NOTES
    """Notes that belong to the entry."""

    @property
    def t_ns(self) -> int:
        """The time at which it began, in nanoseconds since the start of the run."""
        return self.ints[0]


def read_entries(blocks: Iterable[TraceBlock]) -> Generator[Entry, None, None]:
    """Return the entries of a trace, each with all its notes.

    It ends at a gap between two blocks. The last entry of a trace that was cut off is left out,
    because notes of it may be missing.
    """
    steps = _STEPS
    # The entry that has begun. It is made when the next one begins, and all its notes are known.
    number, kind, payload, notes = -1, Kind.BEGIN, b"", NO_NOTES
    numbers: Sequence[int] = ()
    payloads: deque[bytes] = deque()
    for block in blocks:
        if block.first_entry != number + 1:
            return
        payloads.extend(map(as_bytes, block.payloads))
        ints = block.ints
        place, end = 0, len(ints)
        while place < end:
            code = ints[place]
            first = place + 1
            length, begun, has_payload = steps[code]
            place += length
            if begun is not None:
                if number >= 0:
                    yield Entry(number, kind, numbers, payload, notes)
                number, kind, numbers, notes = number + 1, begun, ints[first:place], NO_NOTES
                payload = payloads.popleft() if has_payload else b""
            elif number >= 0:
                if notes is NO_NOTES:
                    notes = Notes()
                _add_note(notes, code, ints[first:place], payloads)
    if kind is Kind.END:
        yield Entry(number, kind, numbers, payload, notes)


def _add_note(notes: Notes, code: int, numbers: Sequence[int], payloads: deque[bytes]) -> None:
    if code == _READ_MONO:
        notes.mono = _joined(notes.mono, numbers[0])
    elif code == _READ_DATE:
        notes.date = _joined(notes.date, numbers[0])
    elif code == _READ_SLEPT:
        notes.slept = _joined(notes.slept, numbers[0])
    elif code == _READ_LOG:
        notes.log = _joined(notes.log, numbers[0])
    elif code == _FACT:
        notes.facts = _joined(notes.facts, from_json(payloads.popleft()))
    elif code == _NEW:
        made = Creation(numbers[0], numbers[1], payloads.popleft().decode())
        notes.created = _joined(notes.created, made)
    elif code == _PERIOD:
        notes.periods = _joined(notes.periods, numbers)
    else:
        notes.spoiled = payloads.popleft().decode()


def _joined(values: deque[T], value: T) -> deque[T]:
    if values is _NOTHING:
        return deque((value,))
    values.append(value)
    return values
