"""Reports of a source on what runs: data that the model takes, whatever they come from."""

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, TypeAlias

from attrs import field, frozen

from rosbase.control.shapes import LogRecord, Process, Statistics, Topic
from rosbase.wire.plain import decoder

__all__ = [
    "Counted",
    "Heard",
    "Logged",
    "NodeKey",
    "NodeReport",
    "NodeRow",
    "ParameterRow",
    "Position",
    "Report",
    "Said",
    "Survey",
    "TopicKey",
]

TopicKey: TypeAlias = tuple[str, int]
"""Name of a topic, and the first pid of the processes that share it."""
NodeKey: TypeAlias = tuple[str, int]
"""Name of a node, or the key of a plain one, and its pid."""


@frozen
class NodeRow:
    """A node, as it is asked for by name."""

    key: NodeKey
    program: str
    lifecycle: str | None


@frozen
class Survey:
    """All programs with their topics and nodes, at one moment."""

    processes: Sequence[Process]
    topics: Mapping[TopicKey, Topic]
    nodes: Sequence[NodeRow]
    loops: Sequence[Statistics]
    silent: frozenset[int] = frozenset()
    """Pids of processes that exist and do not answer: this is what they have told before."""
    trouble: str = ""
    """Line that the user should read until the next survey."""


@frozen
class Counted:
    """Messages of a topic since the report before."""

    topic: TopicKey
    count: int
    seconds: float
    age_s: float = 0.0
    """Time from the last message to the report."""
    is_first: bool = False
    """Whether what was counted before is of another time, which was left."""


@frozen
class Heard:
    """A message of a topic that is looked at."""

    topic: TopicKey
    type: str
    schema: str
    """Text of `ros2msg`, as `rosbase topic type` has it."""
    stamp_ns: int | None
    """When it was published, in nanoseconds since 1970; None for one that was kept."""
    data: bytes
    """The message as CDR."""
    dropped: int = 0
    """Messages that were lost so far, because nobody took them in time."""
    _read: list[Mapping[str, Any]] = field(factory=list, eq=False, init=False, repr=False)

    @property
    def message(self) -> Mapping[str, Any]:
        """Return the fields by name, as `rosbase.wire.plain` reads them. They are read once.

        Raises:
            WireError: The bytes are no message of that type.
        """
        if not self._read:
            self._read.append(_reader(self.type, self.schema)(self.data))
        return self._read[0]


@lru_cache(maxsize=256)
def _reader(type_name: str, schema: str) -> Callable[[bytes], Mapping[str, Any]]:
    return decoder(type_name, schema)


@frozen
class Logged:
    """Records of the log, oldest first."""

    records: Sequence[LogRecord]
    is_first: bool = False
    """Whether the records before are of another time, which was left."""


@frozen
class ParameterRow:
    """A parameter with its value and its meaning."""

    name: str
    kind: str
    value: Any
    description: str
    constraints: str
    is_read_only: bool


@frozen
class NodeReport:
    """Parameters of the node that is looked at, and the transitions that it offers."""

    node: NodeKey
    parameters: Sequence[ParameterRow]
    transitions: Sequence[str]


@frozen
class Said:
    """Something that the user should read: the result of a change, or what cannot be shown."""

    text: str
    is_error: bool = False


@frozen
class Position:
    """Where a recording is. Times are in nanoseconds since 1970."""

    now_ns: int
    begin_ns: int
    end_ns: int
    is_playing: bool
    rate: float = 1.0
    """Speed: 2 is twice as fast as it was recorded."""


Report: TypeAlias = Survey | Counted | Heard | Logged | NodeReport | Said | Position
