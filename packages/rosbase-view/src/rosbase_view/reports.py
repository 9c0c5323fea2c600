"""Reports of a source on what runs: data that the model takes, whatever they come from."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from attrs import frozen

from rosbase.control.shapes import LogRecord, Process, Statistics, Topic

__all__ = [
    "Counted",
    "Heard",
    "Logged",
    "NodeKey",
    "NodeReport",
    "NodeRow",
    "ParameterRow",
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
    """What runs at one moment."""

    processes: Sequence[Process]
    topics: Mapping[TopicKey, Topic]
    nodes: Sequence[NodeRow]
    loops: Sequence[Statistics]


@frozen
class Counted:
    """Messages of a topic since the report before."""

    topic: TopicKey
    count: int
    seconds: float


@frozen
class Heard:
    """The last message of the topic that is looked at."""

    topic: TopicKey
    type: str
    stamp_ns: int | None
    """When it was published, in nanoseconds since 1970; None for one that was kept."""
    message: Mapping[str, Any]
    dropped: int


@frozen
class Logged:
    """Records of the log, oldest first."""

    records: Sequence[LogRecord]


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
    """Something that the user should read: the result of a change, or a program that is silent."""

    text: str
    is_error: bool = False


Report: TypeAlias = Survey | Counted | Heard | Logged | NodeReport | Said
