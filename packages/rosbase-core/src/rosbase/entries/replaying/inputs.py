"""Inputs from outside in a free replay: each at its time, in the order of the file."""

from collections.abc import Callable, Iterable, Iterator

from attrs import frozen

from rosbase.entries.kinds import Kind
from rosbase.entries.script import Entry

__all__ = ["INPUTS", "Input", "Inputs", "inputs_of"]

INPUTS: frozenset[int] = frozenset(
    {
        Kind.TIMER_OP,
        Kind.FRAME,
        Kind.PUBLISH,
        Kind.ARRIVE,
        Kind.REQUEST,
        Kind.ANSWER,
        Kind.CONTROL,
        Kind.PARAM,
        Kind.CHANGE_STATE,
        Kind.POSTED,
        Kind.LOG,
        Kind.STOP,
    }
)
"""The kinds of entries that come from outside."""


@frozen
class Input:
    """Something that comes from outside."""

    t_ns: int
    """Its time, in nanoseconds since the start of the run."""
    play: Callable[[], object]
    """Lets it come in."""


class Inputs:
    """The inputs that have not come in yet. The last one should be a stop."""

    def __init__(self, inputs: Iterable[Input]) -> None:
        self._rest: Iterator[Input] = iter(inputs)
        self._next = next(self._rest, None)

    @property
    def next_ns(self) -> int | None:
        """Time of the next input, since the start of the run; None if there is none."""
        return None if self._next is None else self._next.t_ns

    def play_one(self) -> None:
        """Let the next input come in. Do nothing if there is none."""
        arrived, self._next = self._next, next(self._rest, None)
        if arrived is not None:
            arrived.play()

    def drop(self) -> None:
        """Let no further input come in."""
        self._rest, self._next = iter(()), None


def inputs_of(
    entries: Iterable[Entry], play: Callable[[Entry], object], stop: Callable[[], object]
) -> Iterator[Input]:
    """Return the inputs among the entries of a script, and a stop at its end.

    Args:
        entries: The rest of a script.
        play: Lets an entry come in.
        stop: Stops the program.
    """
    t_ns = 0
    for entry in entries:
        t_ns = entry.t_ns
        play_this = _playing(play, entry)
        yield Input(t_ns, play_this)
    yield Input(t_ns, stop)


def _playing(play: Callable[[Entry], object], entry: Entry) -> Callable[[], object]:
    return lambda: play(entry)
