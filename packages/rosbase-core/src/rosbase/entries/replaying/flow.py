"""Where a replay first did something else than the recording, and what. Pure."""

from collections.abc import Callable, Iterable

from attrs import frozen

from rosbase.entries.kinds import NUMBERED, SECTION_OPS, Kind, Numbered
from rosbase.entries.script import Entry

__all__ = ["FlowDifference", "entry_text", "joined", "period_text", "time_text"]

_WORDS = {
    Kind.BEGIN: "the construction",
    Kind.TICK_END: "the end of a tick",
    Kind.LOOK: "the upkeep between ticks",
    Kind.CALL: "a call",
    Kind.URGENT: "an urgent call",
    Kind.RETURN: "the end of a wait",
    Kind.PARAM: "a request to set parameters",
    Kind.CHANGE_STATE: "a request for a transition of",
    Kind.CONTROL: "a request of the control socket",
    Kind.POSTED: "a call of another thread",
    Kind.LOG: "a log line from outside",
    Kind.STOP: "a request to stop",
    Kind.END: "the end of the run",
    Kind.TIMER: "timer",
    Kind.TIMER_OP: "an operation of another thread on timer",
    Kind.FRAME: "frame of",
    Kind.PUBLISH: "message of another thread on",
    Kind.ARRIVE: "message from outside on",
    Kind.REQUEST: "request for",
    Kind.ANSWER: "answer of",
}
_NS_PER_MS = 1_000_000
_TextOf = Callable[[Numbered, int], str]


@frozen
class FlowDifference:
    """The first entry that the program did not run as it did when it was recorded."""

    number: int
    """Number of the entry that ran."""
    t_ns: int
    """Its time, in nanoseconds since the start of the run."""
    tick: int
    """Number of ticks that had begun."""
    what: str
    """The difference, in one line."""
    before: tuple[str, ...] = ()
    """The entry that ran and the ones before it, the last first."""
    hint: str = ""
    """Other differences in this entry; empty if there are none."""

    def __str__(self) -> str:
        lines = [
            f"first difference at {time_text(self.t_ns)}, entry {self.number} (tick {self.tick}): "
            f"{self.what}"
        ]
        if self.before:
            lines.append(f"before: {', '.join(self.before)}")
        if self.hint:
            lines.append(f"hint: {self.hint}")
        return "\n".join(lines)


def entry_text(entry: Entry, text_of: _TextOf) -> str:
    """Return an entry in a few words, such as `frame of serial (00:12.341)`.

    Args:
        entry: The entry.
        text_of: The text of an object by its class and number.
    """
    return f"{_what(entry, text_of)} ({time_text(entry.t_ns)})"


def time_text(t_ns: int) -> str:
    """Return a time since the start of a run as minutes, seconds and milliseconds."""
    minutes, milliseconds = divmod(t_ns // _NS_PER_MS, 60_000)
    return f"{minutes:02}:{milliseconds // 1000:02}.{milliseconds % 1000:03}"


def period_text(what: int, text: str, period_ns: int, recorded_ns: int) -> str:
    """Return that something runs more often than in the recording, or less often.

    Args:
        what: Its class.
        text: Its text.
        period_ns: Its period, in nanoseconds.
        recorded_ns: The period that it had.
    """
    if what == Numbered.LOOP:
        return f"the main loop has rate {1e9 / period_ns:g} Hz, recorded {1e9 / recorded_ns:g} Hz"
    return f"timer {text} has period {period_ns / 1e9:g} s, recorded {recorded_ns / 1e9:g} s"


def _what(entry: Entry, text_of: _TextOf) -> str:
    kind = entry.kind
    if kind == Kind.TICK:
        return "a tick"
    named = NUMBERED.get(kind)
    name = text_of(named, entry.ints[1]) or f"#{entry.ints[1]}" if named is not None else ""
    if kind == Kind.SECTION:
        return f"{SECTION_OPS[entry.ints[2]]} of {name}"
    return f"{_WORDS[kind]} {name}".rstrip()


def joined(entries: Iterable[Entry], text_of: _TextOf) -> tuple[str, ...]:
    """Return some entries in a few words each."""
    return tuple(entry_text(entry, text_of) for entry in entries)
