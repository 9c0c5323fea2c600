"""Where a replay begins to differ from its recording.

Up to the first difference in the flow of the program, entry by entry. From there on the numbers of
entries do not agree any more, so each message is compared with the one of its topic that was as
many messages after the start.
"""

from collections import deque
from collections.abc import Callable
from enum import Enum

from attrs import frozen

from rosbase_mcap.outputs import MASK, Output
from rosbase_mcap.records import Schema
from rosbase_mcap.replaying.fields import Changes, changes
from rosbase_mcap.replaying.recorded_outputs import RecordedOutputs

__all__ = ["Comparison", "Difference", "Flow", "Kind", "clock_text"]

_MOST_FIELDS = 10
# A topic that falls as far behind in a replay is not published any more.
_MOST_BEHIND = 1_000


class Kind(Enum):
    """Ways to differ."""

    CHANGED = "is another"
    MISSING = "is not published any more"
    NEW = "is new"
    FLOW = "another flow"


@frozen
class Flow:
    """Where a program begins to take another way than in the recording."""

    what: str
    """In words."""
    number: int
    """Number of the entry."""
    since_ns: int
    """Time since the start of the recording, in nanoseconds."""
    context: tuple[str, ...] = ()
    """Lines about the entry, and those before it."""


@frozen
class Difference:
    """Where a replay begins to differ from its recording."""

    kind: Kind
    topic: str
    """Topic of the message; empty if only the flow differs."""
    number: int
    """Number of the entry."""
    since_ns: int
    """Time since the start of the recording, in nanoseconds."""
    changes: Changes
    """Of a message that is another: its fields."""
    count: int
    """How many messages before it are the same."""
    instead: str = ""
    """Topic that was published in its place."""
    flow: "Flow | None" = None
    """In what the flow of the program differs, if that came first."""
    context: tuple[str, ...] = ()
    """Lines about the entry, and those before it."""

    def __str__(self) -> str:
        """Return it as lines for people."""
        if self.kind is Kind.FLOW:
            return "\n".join([self._flow_heading(), *self.context])
        message = [f"{self._heading()}{self._kind()}", *self._fields()]
        if self.flow is None:
            return "\n".join([*message, *self.context])
        return "\n".join([self._flow_heading(), *self.context, *message])

    def _flow_heading(self) -> str:
        flow = self.flow
        assert flow is not None
        return f"first difference at {clock_text(flow.since_ns)}, entry {flow.number}: {flow.what}"

    def _heading(self) -> str:
        when = clock_text(self.since_ns)
        if self.flow is not None:
            return f"then, at {when}, {self.topic}"
        return f"first difference at {when}, entry {self.number}, {self.topic}"

    def _kind(self) -> str:
        what = "" if self.kind is Kind.CHANGED else f" {self.kind.value}"
        return what + (f"; {self.instead} comes instead" if self.instead else "")

    def _fields(self) -> list[str]:
        if self.kind is not Kind.CHANGED:
            return []
        shown = self.changes.fields[:_MOST_FIELDS]
        lines = [f"    {change}" for change in shown]
        if lines:
            lines[0] += "   (recorded -> replayed)"
        more = len(self.changes.fields) - len(shown)
        rest = [f"{more} more differ"] if more else []
        rest += [f"{self.changes.equal} other fields are equal"] if self.changes.equal else []
        return [*lines, *([f"    {', '.join(rest)}"] if rest else [])]


class Comparison:
    """Compares what a replay publishes, message by message, with the recording."""

    def __init__(
        self,
        recorded: RecordedOutputs,
        start_ns: int,
        *,
        context: Callable[[], tuple[str, ...]] = lambda: (),
    ) -> None:
        """Begin.

        Args:
            recorded: What was published in the recording, in its order.
            start_ns: Start of the recording, in nanoseconds since 1970.
            context: Returns lines about the entry that the replay is in.
        """
        self._recorded, self._start_ns = recorded, start_ns
        self._context = context
        self._new: dict[str, Schema] = {}
        self._kept: dict[str, deque[Output]] = {}
        self._flow: Flow | None = None
        self.count = 0
        """How many messages are the same."""
        self.difference: Difference | None = None
        """The first difference; None as long as there is none. The flow counts in `finish`."""

    def declare(self, topic: str, schema: Schema) -> None:
        """Take the schema of a topic in the replay."""
        self._new[topic] = schema

    @property
    def has_other_flow(self) -> bool:
        """Whether the program takes another way than in the recording."""
        return self._flow is not None

    def differ_in_flow(self, flow: Flow) -> None:
        """From here on the program takes another way. Only the first time counts."""
        if self._flow is None:
            self._flow = flow

    def hear(self, number: int, topic: str, log_ns: int, data: bytes) -> None:
        """Compare the next message of the replay, given as the values of an `Output`."""
        if self.difference is not None:
            return
        if self._flow is None and self._recorded.repeats(number, topic, data):
            self.count += 1
            return
        one = next(self._recorded, None) if self._flow is None else self._next_of(topic)
        output = Output(number, topic, log_ns, data)
        if one is None:
            self._differ(Kind.NEW, output)
        elif self._flow is None and (one.number, one.topic) != (output.number, output.topic):
            self._misplaced(one, output)
        elif one.data != output.data:
            self._changed(one, output)
        if self.difference is None:
            self.count += 1

    def finish(self, number: int | None = None, end_ns: int | None = None) -> Difference | None:
        """Return the first difference, now that the replay is over.

        Args:
            number: Number of the last entry; messages of later ones are not missing. None for the
                end of the recording. After another flow, `end_ns` counts instead.
            end_ns: Where it has ended, in nanoseconds since 1970.
        """
        if self.difference is None:
            left = self._left()
            if left is not None and not self._is_behind(left, number, end_ns):
                self._differ(Kind.MISSING, left)
        flow = self._flow
        if self.difference is None and flow is not None:
            place = Kind.FLOW, "", flow.number, flow.since_ns, Changes((), 0), self.count, ""
            self.difference = Difference(*place, flow, flow.context)
        return self.difference

    def _next_of(self, topic: str) -> Output | None:
        """Return the recorded message of a topic with which the next one is compared.

        For a program that takes another way than in the recording.
        """
        kept = self._kept.get(topic)
        if kept:
            return kept.popleft()
        for one in self._recorded:
            if one.topic == topic:
                return one
            self._kept.setdefault(one.topic, deque()).append(one)
            if len(self._kept[one.topic]) > _MOST_BEHIND:
                self._differ(Kind.MISSING, self._kept[one.topic][0])
                return one
        return None

    def _left(self) -> Output | None:
        """Return the first recorded message that was not replayed."""
        firsts = [kept[0] for kept in self._kept.values() if kept]
        firsts += [one] if (one := next(self._recorded, None)) else []
        return min(firsts, key=lambda one: one.log_ns, default=None)

    def _is_behind(self, left: Output, number: int | None, end_ns: int | None) -> bool:
        if self._flow is not None:
            return end_ns is not None and left.log_ns > end_ns
        return number is not None and _is_later(left.number, number)

    def _misplaced(self, one: Output, output: Output) -> None:
        if one.number == output.number:
            self._differ(Kind.MISSING, one, instead=output.topic)
        elif _is_later(output.number, one.number):
            self._differ(Kind.MISSING, one)
        else:
            self._differ(Kind.NEW, output)

    def _changed(self, one: Output, output: Output) -> None:
        schemas = self._recorded.schemas.get(one.topic), self._new.get(output.topic)
        found = changes(one.data, output.data, *schemas)
        # Of a line of the log, what a replay must repeat may be the same.
        if found.fields:
            self._differ(Kind.CHANGED, one, found)

    def _differ(
        self, kind: Kind, at: Output, found: Changes | None = None, instead: str = ""
    ) -> None:
        if self.difference is not None:
            return
        since_ns = max(0, at.log_ns - self._start_ns)
        place = kind, at.topic, at.number, since_ns, found or Changes((), 0), self.count
        context = self._context() if self._flow is None else self._flow.context
        self.difference = Difference(*place, instead, self._flow, context)


def _is_later(number: int, other: int) -> bool:
    """Return whether an entry comes after another. Numbers have 32 bits: the shorter way counts."""
    return 0 < (number - other) & MASK < 1 << 31


def clock_text(since_ns: int) -> str:
    """Return a time since the start, such as `00:12.345`."""
    minutes, rest_ns = divmod(since_ns, 60_000_000_000)
    hours, minutes = divmod(minutes, 60)
    first = f"{hours}:{minutes:02}" if hours else f"{minutes:02}"
    return f"{first}:{rest_ns // 10**9:02}.{rest_ns // 10**6 % 1000:03}"
